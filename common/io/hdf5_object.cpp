#include "common/io/hdf5_object.h"

#include <cstdio>

namespace heartbus::io {
namespace {

Hdf5Object without_locks() {
  static const herr_t no_exit_handler = H5dont_atexit(); // counts only before the first other call
  static_cast<void>(no_exit_handler);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  Hdf5Object access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "describe the access to a file");
  require(H5Pset_file_locking(access, false, true), "open files without locks");
  return access;
}

} // namespace

void require(herr_t status, const std::string &what) {
  if (status < 0)
    throw Failure(ExitCode::file, "cannot " + what);
}

Hdf5Object create_file(const std::string &name, const std::string &what) {
  const Hdf5Object access = without_locks();
  return {H5Fcreate(name.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose, what};
}

Hdf5Object open_file(const std::string &name, const std::string &what) {
  const Hdf5Object access = without_locks();
  return {H5Fopen(name.c_str(), H5F_ACC_RDONLY, access), H5Fclose, what};
}

void publish(const std::string &temporary, const std::string &name) {
  if (std::rename(temporary.c_str(), name.c_str()) != 0)
    throw Failure(ExitCode::file, "cannot write " + name);
}

} // namespace heartbus::io
