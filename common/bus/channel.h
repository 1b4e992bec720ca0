#pragma once

#include "common/bus/protocol.h"
#include "common/bus/shared_memory.h"
#include "common/bus/world.h"

#include <atomic>
#include <cstdint>
#include <memory>
#include <mpi.h>

namespace heartbus::bus {

/// Where the messages of one rank to one other on one route lie, one after another: n numbers each, two in turn, so
/// that the sender may write one while the receiver has yet to read the one before. On one node both see the same
/// buffer and nothing is copied in between; from node to node each has its own, the first message of which MPI carries.
struct MessageBuffer {
  alignas(64) std::atomic<std::uint32_t> shared; ///< the sender sees this very buffer
  std::atomic<std::uint32_t> sent;               ///< messages so far
  std::atomic<std::uint32_t> wanted;             ///< the sender sleeps until one is taken
  alignas(64) std::atomic<std::uint32_t> taken;  ///< messages so far

  static constexpr std::uint32_t n_messages = 2;
  static std::size_t bytes(std::size_t n) { return sizeof(MessageBuffer) + n_messages * pitch(n) * sizeof(double); }
  double *message(std::uint32_t k, std::size_t n) {
    return reinterpret_cast<double *>(this + 1) + k % n_messages * pitch(n);
  }

 private:
  static std::size_t pitch(std::size_t n) { return (n + 7) / 8 * 8; }
};

/// How the sender finds the receiver's buffer.
struct BufferAddress {
  SharedMemory::Ticket memory;
  std::uint64_t offset = 0;
};

/// The sending end. Of the buffer it is told by the receiver; until then it is not free.
class OutgoingChannel {
 public:
  OutgoingChannel(const World &world, int route, Peer peer, std::size_t n_numbers);

  const Peer &peer() const { return peer_; }
  bool is_free(); ///< whether the next message may be written; if not, the receiver rings when it may
  double *message() { return buffer_->message(buffer_->sent, n_numbers_); } ///< to be written; needs is_free()
  void send();                                                              ///< does not ring
  bool needs_help(); ///< whether MPI has yet to carry a message, which it may do only while it is called
  void close();

 private:
  void use_buffer_at(const BufferAddress &address);
  void use_own_buffer();

  const World *world_;
  int route_;
  Peer peer_;
  std::size_t n_numbers_;
  std::unique_ptr<BufferAddress> address_; ///< MPI writes here
  std::unique_ptr<SharedMemory> memory_;   ///< of the buffer: the receiver's or its own
  MessageBuffer *buffer_ = nullptr;
  bool is_shared_ = false;                 ///< with the receiver
  MPI_Request request_ = MPI_REQUEST_NULL; ///< of the address, then of messages unless the buffer is shared
};

/// The receiving end, always ready for the next message.
class IncomingChannel {
 public:
  IncomingChannel(const World &world, int route, Peer peer, std::size_t n_numbers, MessageBuffer *buffer,
                  const BufferAddress &address);

  const Peer &peer() const { return peer_; }
  bool has_arrived();
  const double *message() const { return buffer_->message(n_taken_, n_numbers_); } ///< needs has_arrived()
  void take();                                                                     ///< after reading
  void close();

 private:
  const World *world_;
  Peer peer_;
  std::size_t n_numbers_;
  MessageBuffer *buffer_;
  std::uint32_t n_taken_ = 0;
  MPI_Request request_ = MPI_REQUEST_NULL;
};

} // namespace heartbus::bus
