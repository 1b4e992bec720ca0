#pragma once

#include <optional>
#include <string>
#include <utility>

namespace heartbus::coupler {

/// A lock on a file that other programs of this project heed. It goes with its process, however that ends.
class FileLock {
 public:
  enum class Kind { shared, exclusive };
  /// None when somebody else holds it; a shared one suffers other shared ones. When the file cannot be opened, or its
  /// file system has no locks, the lock is empty: that stops nobody.
  static std::optional<FileLock> take(const std::string &file_name, Kind kind);
  FileLock(FileLock &&other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FileLock &operator=(FileLock &&other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~FileLock();
  /// Writes who holds it, in place of what the file contains.
  void sign(const std::string &text) const;

 private:
  explicit FileLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
};

/// Makes this run the only one of a folder of results until the lock goes. Failure(file) that names process and machine
/// of the run that is there already.
FileLock lock_results(const std::string &folder);

} // namespace heartbus::coupler
