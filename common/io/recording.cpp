#include "common/io/recording.h"

#include "common/io/hdf5_object.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

namespace heartbus::io {
namespace {

void require(herr_t status, const std::string &what) {
  if (status < 0)
    throw Failure(ExitCode::file, "cannot " + what);
}

/// HDF5 prints its own stack of errors; ours says what is needed.
void silence_hdf5() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

Hdf5Object text_type(std::size_t size) {
  Hdf5Object type(H5Tcopy(H5T_C_S1), H5Tclose, "describe a text");
  H5Tset_size(type, size);
  return type;
}

void write_text(hid_t object, const std::string &name, const std::string &text) {
  const Hdf5Object type = text_type(text.size() + 1);
  const Hdf5Object space(H5Screate(H5S_SCALAR), H5Sclose, "describe attribute " + name);
  const Hdf5Object attribute(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                             "create attribute " + name);
  require(H5Awrite(attribute, type, text.c_str()), "write attribute " + name);
}

std::string read_text(hid_t object, const std::string &name) {
  const Hdf5Object attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, "find attribute " + name);
  const Hdf5Object type(H5Aget_type(attribute), H5Tclose, "read the type of attribute " + name);
  std::string text(H5Tget_size(type), '\0');
  require(H5Aread(attribute, type, text.data()), "read attribute " + name);
  return text.c_str();
}

/// A table that grows by rows, one row a chunk.
template <std::size_t rank>
Hdf5Object create_table(hid_t file, const std::string &name, hid_t type, std::array<hsize_t, rank> row) {
  std::array<hsize_t, rank> limit = row, none = row;
  limit[0] = H5S_UNLIMITED;
  none[0] = 0;
  const Hdf5Object space(H5Screate_simple(rank, none.data(), limit.data()), H5Sclose, "describe " + name);
  const Hdf5Object properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "describe the chunks of " + name);
  require(H5Pset_chunk(properties, rank, row.data()), "set the chunks of " + name);
  return {H5Dcreate2(file, name.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT), H5Dclose,
          "create " + name};
}

template <std::size_t rank>
void append_row(hid_t table, hid_t type, hsize_t n_rows, std::array<hsize_t, rank> row, const void *data) {
  row[0] = n_rows + 1;
  require(H5Dset_extent(table, row.data()), "extend a recording");
  std::array<hsize_t, rank> start{};
  start[0] = n_rows;
  row[0] = 1;
  const Hdf5Object space(H5Dget_space(table), H5Sclose, "extend a recording");
  require(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, row.data(), nullptr), "select a row");
  const Hdf5Object memory(H5Screate_simple(rank, row.data(), nullptr), H5Sclose, "describe a row");
  require(H5Dwrite(table, type, memory, space, H5P_DEFAULT, data), "write a recording (is the disk full?)");
}

std::vector<hsize_t> extent(hid_t table) {
  const Hdf5Object space(H5Dget_space(table), H5Sclose, "read the extent of a table");
  std::vector<hsize_t> sizes(H5Sget_simple_extent_ndims(space));
  H5Sget_simple_extent_dims(space, sizes.data(), nullptr);
  return sizes;
}

template <class T>
std::vector<T> read_all(hid_t file, const std::string &name, hid_t type) {
  const Hdf5Object table(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose, "find " + name);
  hsize_t size = 1;
  for (const hsize_t n : extent(table))
    size *= n;
  std::vector<T> values(size);
  if (size > 0)
    require(H5Dread(table, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), "read " + name);
  return values;
}

} // namespace

struct RecordingWriter::Implementation {
  Implementation(const std::string &file_name, const RecordedField &field)
      : file_name(file_name), n_points(field.coordinates.size() / 3), components(field.components),
        file(H5Fcreate(file_name.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose,
             "create the recording " + file_name),
        values(create_table<3>(file, "values", H5T_NATIVE_DOUBLE, {1, n_points, components})),
        steps(create_table<1>(file, "step", H5T_NATIVE_INT, {1})),
        times(create_table<1>(file, "time", H5T_NATIVE_DOUBLE, {1})) {
    const std::array<hsize_t, 2> size{n_points, 3};
    const Hdf5Object space(H5Screate_simple(2, size.data(), nullptr), H5Sclose, "describe points");
    const Hdf5Object points(H5Dcreate2(file, "points", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                            H5Dclose, "create points");
    require(H5Dwrite(points, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, field.coordinates.data()),
            "write points");
    write_text(points, "field", field.name);
    write_text(points, "unit", field.unit);
  }

  const std::string file_name;
  const hsize_t n_points, components;
  hsize_t n_rows = 0;
  Hdf5Object file, values, steps, times;
};

RecordingWriter::RecordingWriter(const std::string &file_name, const RecordedField &field) {
  silence_hdf5();
  if (field.coordinates.empty())
    throw Failure(ExitCode::file, "recording " + file_name + ": field '" + field.name + "' has no points");
  implementation_ = std::make_unique<Implementation>(file_name, field);
}
RecordingWriter::~RecordingWriter() = default;
RecordingWriter::RecordingWriter(RecordingWriter &&) noexcept = default;

void RecordingWriter::append(int step, double time, const std::vector<double> &values) {
  Implementation &to = *implementation_;
  if (values.size() != to.n_points * to.components)
    throw Failure(ExitCode::file, "recording " + to.file_name + ": " + std::to_string(values.size()) +
                                      " values instead of " + std::to_string(to.n_points * to.components));
  append_row<3>(to.values, H5T_NATIVE_DOUBLE, to.n_rows, {1, to.n_points, to.components}, values.data());
  append_row<1>(to.steps, H5T_NATIVE_INT, to.n_rows, {1}, &step);
  append_row<1>(to.times, H5T_NATIVE_DOUBLE, to.n_rows, {1}, &time);
  ++to.n_rows;
  require(H5Fflush(to.file, H5F_SCOPE_LOCAL), "write the recording " + to.file_name);
}

struct RecordingReader::Implementation {
  explicit Implementation(const std::string &file_name)
      : file_name(file_name),
        file(H5Fopen(file_name.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, "open the recording " + file_name),
        table(H5Dopen2(file, "values", H5P_DEFAULT), H5Dclose, "find values in the recording " + file_name),
        size(extent(table)), steps(read_all<int>(file, "step", H5T_NATIVE_INT)),
        times(read_all<double>(file, "time", H5T_NATIVE_DOUBLE)) {
    const Hdf5Object points(H5Dopen2(file, "points", H5P_DEFAULT), H5Dclose, "find points in the recording");
    field = {read_text(points, "field"), read_text(points, "unit"), static_cast<unsigned>(size.at(2)),
             read_all<double>(file, "points", H5T_NATIVE_DOUBLE)};
  }

  const std::string file_name;
  Hdf5Object file, table;
  std::vector<hsize_t> size; ///< transfers, points, components
  RecordedField field;
  std::vector<int> steps;
  std::vector<double> times;
};

RecordingReader::RecordingReader(const std::string &file_name) {
  silence_hdf5();
  implementation_ = std::make_unique<Implementation>(file_name);
}
RecordingReader::~RecordingReader() = default;
RecordingReader::RecordingReader(RecordingReader &&) noexcept = default;

const RecordedField &RecordingReader::field() const { return implementation_->field; }
const std::vector<int> &RecordingReader::steps() const { return implementation_->steps; }
const std::vector<double> &RecordingReader::times() const { return implementation_->times; }

std::vector<double> RecordingReader::values(std::size_t transfer) const {
  const Implementation &from = *implementation_;
  const std::array<hsize_t, 3> start{transfer, 0, 0}, count{1, from.size[1], from.size[2]};
  std::vector<double> values(count[1] * count[2]);
  const Hdf5Object space(H5Dget_space(from.table), H5Sclose, "read the extent of a recording");
  require(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr), "select a row");
  const Hdf5Object memory(H5Screate_simple(3, count.data(), nullptr), H5Sclose, "describe a row");
  require(H5Dread(from.table, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, values.data()), "read a recording");
  return values;
}

void RecordingReader::refuse(const std::string &what) const {
  throw Failure(ExitCode::file, "recording " + implementation_->file_name + " of field '" + field().name + "' " + what);
}

std::size_t RecordingReader::transfer_of(std::size_t any, int k) const {
  const auto [begin, end] = std::equal_range(steps().begin(), steps().end(), steps()[any]);
  if (end - begin <= k)
    refuse("holds " + std::to_string(end - begin) + " transfers in step " + std::to_string(steps()[any]) +
           ", iteration " + std::to_string(k) + " has none");
  return begin - steps().begin() + k;
}

std::vector<double> RecordingReader::values_at(double time, int k) const {
  const auto &t = times();
  if (t.empty())
    refuse("is empty");
  const double same = 1e-9 * std::abs(time); // recorded times are sums of steps
  const auto after = std::lower_bound(t.begin(), t.end(), time - same);
  std::ostringstream where;
  where.precision(12);
  if (after == t.end()) {
    where << "ends at t = " << t.back() << " s, this run is at t = " << time << " s: record it until then";
    refuse(where.str());
  }
  const std::size_t next = after - t.begin();
  const std::vector<double> late = values(transfer_of(next, k));
  if (t[next] - time <= same)
    return late;
  if (next == 0) {
    const auto second = std::upper_bound(t.begin(), t.end(), t.front());
    if (second == t.end() || time < 2 * t.front() - *second) {
      where << "begins at t = " << t.front() << " s, this run is at t = " << time << " s: record it from there";
      refuse(where.str());
    }
    return late;
  }
  std::vector<double> result = values(transfer_of(next - 1, k));
  const double share = (time - t[next - 1]) / (t[next] - t[next - 1]);
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] += share * (late[i] - result[i]);
  return result;
}

} // namespace heartbus::io
