#pragma once

#include "common/bus/failure.h"

#include <hdf5.h>
#include <string>
#include <utility>

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
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

} // namespace heartbus::io
