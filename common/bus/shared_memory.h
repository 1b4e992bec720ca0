#pragma once

#include <cstddef>
#include <cstdint>

namespace heartbus::bus {

/// Memory that other processes of the node can reach as well, filled with zeros. It has no name, so nothing is left of
/// it when its processes end, however they do. Linux only (memfd); elsewhere, and where a process may not look into
/// another's descriptors, it remains private, and what is made from its ticket is empty.
class SharedMemory {
 public:
  /// What another process needs to reach it.
  struct Ticket {
    std::int64_t process = 0, file = -1;
    std::uint64_t stamp = 0; ///< first word of the memory: process numbers may be those of another container
  };

  explicit SharedMemory(std::size_t bytes); ///< bad_alloc if there is none
  explicit SharedMemory(const Ticket &ticket);
  SharedMemory(const SharedMemory &) = delete;
  ~SharedMemory();

  const Ticket &ticket() const { return ticket_; }
  /// Behind the stamp, aligned to a cache line; null if it could not be reached.
  char *begin() const { return memory_ ? memory_ + header : nullptr; }

 private:
  static constexpr std::size_t header = 64;
  char *memory_ = nullptr;
  std::size_t bytes_ = 0;
  int file_ = -1;
  Ticket ticket_;
};

} // namespace heartbus::bus
