#pragma once

#include "common/base/failure.h"

#include <hdf5.h>
#include <string>
#include <utility>
#include <vector>

namespace heartbus::io {

/// An HDF5 identifier, closed when it goes out of scope. Failure(file) "cannot <what>" when there is none.
class Hdf5Object {
 public:
  Hdf5Object(hid_t id, herr_t (*close)(hid_t), const std::string &what) : id_(id), close_(close) {
    if (id < 0)
      throw Failure(ExitCode::file, "cannot " + what);
  }
  Hdf5Object(Hdf5Object &&other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  ~Hdf5Object() {
    if (id_ >= 0)
      close_(id_);
  }
  /// Closes it now; what could not be written until then is a Failure(file) "cannot <what>".
  void close(const std::string &what) {
    if (close_(std::exchange(id_, -1)) < 0)
      throw Failure(ExitCode::file, "cannot " + what);
  }
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// Failure(file) "cannot <what>" when HDF5 reports an error.
void require(herr_t status, const std::string &what);

/// Files of HDF5 as this project opens them: without locks, so that who reads never stops who writes and a file system
/// without locks will do; without HDF5's own words on errors; without its exit handler, which crashes when a file could
/// not be written; in the format of HDF5 1.8, whose headers have checksums (that of 1.10 has more of them, but marks a
/// file while it is written, so that nobody can read a copy). `what` is for the message, "create the state x.h5".
Hdf5Object create_file(const std::string &name, const std::string &what);
Hdf5Object open_file(const std::string &name, const std::string &what);

/// A text attribute of an object. Failure(file) when there is none, or it is none.
std::string read_text(hid_t object, const std::string &name);

/// Sizes of a table along its directions.
std::vector<hsize_t> extent(hid_t table);

/// Failure(file) unless all values that a table claims are stored: where the header is damaged, HDF5 1.10 would read
/// beyond the end of what it has. Of compressed chunks the size is known roughly.
void require_all_stored(hid_t table, const std::string &name);

/// All values of a table, row by row, as `type`, which is T. Failure(file) when there is none, it is damaged, or it
/// claims more values than its file can hold.
template <class T>
std::vector<T> read_all(hid_t file, const std::string &name, hid_t type);

/// Renames, so that a reader sees the old file or the new one. Failure(file).
void publish(const std::string &temporary, const std::string &name);

} // namespace heartbus::io
