#include "common/io/hdf5_object.h"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <numeric>

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
  require(H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18), "choose the format of " + name);
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

namespace {

struct Sizes {
  hsize_t least, most;
  bool hold(hsize_t size) const { return least <= size && size <= most; }
};

/// Of a chunk of so many bytes with these filters: one size, unless it is compressed. What is no longer than its
/// checksum HDF5 1.10 would read beyond its end.
Sizes stored_sizes(hid_t properties, hsize_t bytes) {
  constexpr hsize_t frame = 64;
  hsize_t checksum = 0;
  bool is_compressed = false;
  for (int i = 0; i < H5Pget_nfilters(properties); ++i) {
    unsigned flags = 0;
    std::size_t n_parameters = 0;
    const H5Z_filter_t filter = H5Pget_filter2(properties, i, &flags, &n_parameters, nullptr, 0, nullptr, nullptr);
    if (filter == H5Z_FILTER_FLETCHER32)
      checksum = 4;
    else
      is_compressed |= filter != H5Z_FILTER_SHUFFLE;
  }
  bytes += checksum;
  return is_compressed ? Sizes{checksum + 1, bytes + bytes / 100 + frame} : Sizes{bytes, bytes};
}

/// Looked for as reading does, in a time that does not grow with the number of chunks.
bool is_stored(hid_t table, const std::vector<hsize_t> &place, const Sizes &sizes) {
  hsize_t size = 0;
  return H5Dget_chunk_storage_size(table, place.data(), &size) >= 0 && sizes.hold(size);
}

/// By the size that the list of chunks has, where the other one is what the table claims if there are no filters.
bool is_first_stored(hid_t table, std::size_t rank, const Sizes &sizes) {
  const std::vector<hsize_t> place(rank);
  unsigned not_applied = 0;
  haddr_t address = HADDR_UNDEF;
  hsize_t size = 0;
  return H5Dget_chunk_info_by_coord(table, place.data(), &not_applied, &address, &size) >= 0 && sizes.hold(size) &&
         (not_applied == 0 || sizes.least < sizes.most); // what cannot be compressed need not be
}

bool are_chunks_stored(hid_t table, hid_t properties, hsize_t bytes_of_value) {
  const std::vector<hsize_t> sizes = extent(table);
  std::vector<hsize_t> chunk(sizes.size());
  if (H5Pget_chunk(properties, int(chunk.size()), chunk.data()) != int(sizes.size()) ||
      std::count(chunk.begin(), chunk.end(), 0) > 0)
    return false;
  const Sizes stored =
      stored_sizes(properties, std::accumulate(chunk.begin(), chunk.end(), bytes_of_value, std::multiplies<hsize_t>()));
  if (!is_first_stored(table, sizes.size(), stored))
    return false;
  std::vector<hsize_t> place(sizes.size());
  while (is_stored(table, place, stored)) {
    std::size_t i = place.size(); // to the next chunk, counting up the last direction first
    while (i > 0 && (place[i - 1] += chunk[i - 1]) >= sizes[i - 1])
      place[--i] = 0;
    if (i == 0)
      return true;
  }
  return false;
}

} // namespace

void require_all_stored(hid_t table, const std::string &name) {
  const std::vector<hsize_t> sizes = extent(table);
  const hsize_t n = std::accumulate(sizes.begin(), sizes.end(), hsize_t(1), std::multiplies<hsize_t>());
  const Hdf5Object properties(H5Dget_create_plist(table), H5Pclose, "read how " + name + " is stored"),
      type(H5Dget_type(table), H5Tclose, "read the type of " + name);
  const hsize_t bytes = H5Tget_size(type);
  if (n > 0 && !(H5Pget_layout(properties) == H5D_CHUNKED ? are_chunks_stored(table, properties, bytes)
                                                          : H5Dget_storage_size(table) >= n * bytes))
    throw Failure(ExitCode::file, "table " + name + " does not hold the values that it claims: it is damaged");
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
  require_all_stored(table, name);
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
