#include "common/bus/shared_memory.h"

#include <cstring>
#include <fcntl.h>
#include <new>
#include <random>
#include <string>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace heartbus::bus {
namespace {

constexpr char purpose[] = "heartbus";

bool is_ours(const std::string &descriptor) {
  const std::string expected = std::string("/memfd:") + purpose;
  char target[64] = "";
  const ssize_t length = readlink(descriptor.c_str(), target, sizeof target);
  return length > 0 && std::string(target, length).rfind(expected, 0) == 0;
}

int nameless_file(std::size_t bytes) {
#ifdef __linux__
  const int file = memfd_create(purpose, MFD_CLOEXEC);
  if (file >= 0 && ftruncate(file, static_cast<off_t>(bytes)) == 0)
    return file;
  if (file >= 0)
    close(file);
#endif
  (void)bytes;
  return -1;
}

char *map(int file, std::size_t bytes) {
#ifdef MAP_POPULATE
  constexpr int at_once = MAP_POPULATE; // no page is made in the middle of a message
#else
  constexpr int at_once = 0;
#endif
  const int sharing = file < 0 ? MAP_PRIVATE | MAP_ANONYMOUS : MAP_SHARED;
  void *memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, sharing | at_once, file, 0);
  return memory == MAP_FAILED ? nullptr : static_cast<char *>(memory);
}

} // namespace

SharedMemory::SharedMemory(std::size_t bytes) : bytes_(bytes + header), file_(nameless_file(bytes_)) {
  memory_ = map(file_, bytes_);
  if (!memory_)
    throw std::bad_alloc();
  std::random_device entropy;
  ticket_ = {getpid(), file_, (std::uint64_t(entropy()) << 32) | entropy()};
  std::memcpy(memory_, &ticket_.stamp, sizeof ticket_.stamp);
}

SharedMemory::SharedMemory(const Ticket &ticket) : ticket_(ticket) {
  if (ticket.file < 0)
    return;
  const std::string name = "/proc/" + std::to_string(ticket.process) + "/fd/" + std::to_string(ticket.file);
  const int file = is_ours(name) ? open(name.c_str(), O_RDWR | O_CLOEXEC) : -1;
  if (file < 0)
    return;
  struct stat status;
  if (fstat(file, &status) == 0 && status.st_size > off_t(header)) {
    bytes_ = status.st_size;
    memory_ = map(file, bytes_);
  }
  close(file);
  if (memory_ && std::memcmp(memory_, &ticket.stamp, sizeof ticket.stamp) != 0)
    munmap(std::exchange(memory_, nullptr), bytes_);
}

SharedMemory::~SharedMemory() {
  if (memory_)
    munmap(memory_, bytes_);
  if (file_ >= 0)
    close(file_);
}

} // namespace heartbus::bus
