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

std::string read_text(hid_t object, const std::string &name) {
  const Hdf5Object attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, "find attribute " + name);
  const Hdf5Object type(H5Aget_type(attribute), H5Tclose, "read the type of attribute " + name);
  const Hdf5Object space(H5Aget_space(attribute), H5Sclose, "read the extent of attribute " + name);
  constexpr std::size_t longest = 1 << 20;
  if (H5Tget_size(type) > longest || H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) != 0 ||
      H5Sget_simple_extent_npoints(space) != 1)
    throw Failure(ExitCode::file, "attribute " + name + " is not a text");
  std::string text(H5Tget_size(type) + 1, '\0'); // in case its end is not marked
  require(H5Aread(attribute, type, text.data()), "read attribute " + name);
  return text.c_str();
}

std::vector<hsize_t> extent(hid_t table) {
  const Hdf5Object space(H5Dget_space(table), H5Sclose, "read the extent of a table");
  std::vector<hsize_t> sizes(std::max(0, H5Sget_simple_extent_ndims(space)));
  H5Sget_simple_extent_dims(space, sizes.data(), nullptr);
  return sizes;
}

template <class T>
std::vector<T> read_all(hid_t file, const std::string &name, hid_t type) {
  constexpr hsize_t most = 1 << 30, densest = 1100; // values; bytes that one compressed byte can stand for
  const Hdf5Object table(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose, "find " + name);
  hsize_t size = 1;
  for (const hsize_t n : extent(table)) {
    if (n > 0 && size > most / n)
      throw Failure(ExitCode::file, "table " + name + " has more entries than can be");
    size *= n;
  }
  if (size > densest * H5Dget_storage_size(table))
    throw Failure(ExitCode::file, "table " + name + " claims " + std::to_string(size) +
                                      " values, more than its file holds: it is incomplete");
  std::vector<T> values(size);
  if (size > 0)
    require(H5Dread(table, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), "read " + name + " (damaged?)");
  return values;
}

template std::vector<int> read_all(hid_t, const std::string &, hid_t);
template std::vector<unsigned> read_all(hid_t, const std::string &, hid_t);
template std::vector<double> read_all(hid_t, const std::string &, hid_t);

void publish(const std::string &temporary, const std::string &name) {
  if (std::rename(temporary.c_str(), name.c_str()) != 0)
    throw Failure(ExitCode::file, "cannot write " + name);
}

} // namespace heartbus::io
