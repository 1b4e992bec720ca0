#pragma once

#include "common/bus/packer.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <optional>

namespace heartbus::bus {

/// A stream of bytes from one process to another in memory that both see. Nothing that happens in between can hold back
/// what has been written, and the writer needs nobody to make it arrive.
class Pipe {
 public:
  static constexpr std::uint32_t capacity = 1 << 15; ///< [byte]: the orders of a step many times over

  std::size_t write(const char *bytes, std::size_t n);              ///< as many as there is room for; returns how many
  std::size_t read(char *bytes, std::size_t n);                     ///< as many as there are; returns how many
  void want_room() { wanted_ = 1; }                                 ///< the writer will look again before it sleeps
  bool room_was_wanted() { return wanted_ && wanted_.exchange(0); } ///< asked by the reader after it has read

 private:
  alignas(64) std::atomic<std::uint32_t> n_written_{0}; ///< so far, modulo 2^32
  alignas(64) std::atomic<std::uint32_t> n_read_{0};
  std::atomic<std::uint32_t> wanted_{0};
  alignas(64) char bytes_[capacity];
};

/// The pipes of one rank. Orders come down from the coupler and from the first rank of its participant, answers go up.
struct Pipes {
  Pipe from_coupler, to_coupler, from_root, to_root;
};

struct Message {
  int sender = 0, tag = 0;
  Bytes content;
};

/// Writes messages of any length; what finds no room goes later.
class PipeWriter {
 public:
  explicit PipeWriter(Pipe &pipe) : pipe_(pipe) {}
  void post(int tag, Bytes content);
  bool push(); ///< returns whether something has been written
  bool empty() const { return queue_.empty(); }

 private:
  Pipe &pipe_;
  std::deque<Bytes> queue_;
  std::size_t offset_ = 0; ///< in the first of them
};

class PipeReader {
 public:
  explicit PipeReader(Pipe &pipe) : pipe_(pipe) {}
  std::optional<Message> next(); ///< once it is complete; the sender is left open
  bool room_was_wanted() { return pipe_.room_was_wanted(); }

 private:
  bool fill(Bytes &bytes); ///< returns whether it is complete

  Pipe &pipe_;
  Bytes header_, content_;
  std::size_t n_filled_ = 0;
  bool in_content_ = false;
};

} // namespace heartbus::bus
