#include "coupler/file_lock.h"

#include "common/base/failure.h"

#include <cerrno>
#include <fcntl.h>
#include <fstream>
#include <sys/file.h>
#include <unistd.h>

namespace heartbus::coupler {

std::optional<FileLock> FileLock::take(const std::string &file_name, Kind kind) {
  // Over NFS an exclusive lock takes a file that may be written.
  const int descriptor = open(file_name.c_str(), (kind == Kind::shared ? O_RDONLY : O_RDWR) | O_CLOEXEC | O_NONBLOCK);
  if (descriptor >= 0 && flock(descriptor, (kind == Kind::shared ? LOCK_SH : LOCK_EX) | LOCK_NB) != 0 &&
      errno == EWOULDBLOCK) {
    close(descriptor);
    return {};
  }
  return FileLock(descriptor);
}

FileLock::~FileLock() {
  if (descriptor_ >= 0)
    close(descriptor_);
}

void FileLock::sign(const std::string &text) const {
  if (ftruncate(descriptor_, 0) != 0 || pwrite(descriptor_, text.data(), text.size(), 0) < 0)
    return; // the lock holds without a signature
}

namespace {

std::string host() {
  char name[256] = {};
  gethostname(name, sizeof name - 1);
  return name;
}

std::string first_line(const std::string &file_name) {
  std::ifstream file(file_name);
  std::string line;
  std::getline(file, line);
  return line.empty() ? "an unknown process" : line;
}

} // namespace

FileLock lock_results(const std::string &folder) {
  const std::string name = folder + "/.lock";
  close(open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
  auto lock = FileLock::take(name, FileLock::Kind::exclusive);
  if (!lock)
    throw Failure(ExitCode::file, folder + ": another run writes its results there, " + first_line(name) +
                                      "; wait for its end or give this one a folder of its own with --out");
  lock->sign("process " + std::to_string(getpid()) + " on " + host() + "\n");
  return std::move(*lock);
}

} // namespace heartbus::coupler
