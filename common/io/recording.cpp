#include "common/io/recording.h"

#include "common/io/hdf5_object.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <sstream>

namespace heartbus::io {
namespace {

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

/// In chunks of one row, or of all where none is to come, each with a checksum, in a frame of zlib that compresses
/// nothing: the checksum of zeros is zero, and zeros are found where a damaged list of chunks leads to unused space.
template <std::size_t rank>
Hdf5Object create_table(hid_t file, const std::string &name, hid_t type, const std::array<hsize_t, rank> &size,
                        const std::array<hsize_t, rank> &chunk, const std::array<hsize_t, rank> &limit) {
  const Hdf5Object space(H5Screate_simple(rank, size.data(), limit.data()), H5Sclose, "describe " + name);
  const Hdf5Object properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "describe the chunks of " + name);
  require(H5Pset_chunk(properties, rank, chunk.data()), "set the chunks of " + name);
  require(H5Pset_fletcher32(properties), "set the checksums of " + name);
  require(H5Pset_deflate(properties, 0), "set the frame of " + name);
  return {H5Dcreate2(file, name.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT), H5Dclose,
          "create " + name};
}

/// A table that grows by rows, none yet.
template <std::size_t rank>
Hdf5Object create_series(hid_t file, const std::string &name, hid_t type, std::array<hsize_t, rank> row) {
  std::array<hsize_t, rank> limit = row, none = row;
  limit[0] = H5S_UNLIMITED;
  none[0] = 0;
  return create_table(file, name, type, none, row, limit);
}

template <std::size_t rank>
void append_row(hid_t table, hid_t type, hsize_t n_rows, std::array<hsize_t, rank> row, const void *data) {
  row[0] = n_rows + 1;
  require(H5Dset_extent(table, row.data()), "extend a recording (disk full?)");
  std::array<hsize_t, rank> start{};
  start[0] = n_rows;
  row[0] = 1;
  const Hdf5Object space(H5Dget_space(table), H5Sclose, "extend a recording");
  require(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, row.data(), nullptr), "select a row");
  const Hdf5Object memory(H5Screate_simple(rank, row.data(), nullptr), H5Sclose, "describe a row");
  require(H5Dwrite(table, type, memory, space, H5P_DEFAULT, data), "write a recording (is the disk full?)");
}

std::string aside(const std::string &file_name) { return file_name + ".part"; }

/// Of the last transfer [s]; before all when there is no recording that can be read.
double end_of(const std::string &file_name) {
  try {
    const RecordingReader reader(file_name);
    return reader.times().empty() ? -INFINITY : reader.times().back();
  } catch (const Failure &) {
    return -INFINITY;
  }
}

/// What a run was still recording when it ended before its time is the recording, if it came farther.
void salvage(const std::string &file_name) {
  if (end_of(aside(file_name)) > end_of(file_name))
    publish(aside(file_name), file_name);
  std::remove(aside(file_name).c_str());
}

} // namespace

struct RecordingWriter::Implementation {
  Implementation(const std::string &file_name, const RecordedField &field)
      : file_name(file_name), n_points(field.coordinates.size() / 3), components(field.components),
        file(create_file(aside(file_name), "create the recording " + file_name)),
        values(create_series<3>(file, "values", H5T_NATIVE_DOUBLE, {1, n_points, components})),
        steps(create_series<1>(file, "step", H5T_NATIVE_INT, {1})),
        times(create_series<1>(file, "time", H5T_NATIVE_DOUBLE, {1})) {
    const std::array<hsize_t, 2> size{n_points, 3};
    const Hdf5Object points = create_table(file, "points", H5T_NATIVE_DOUBLE, size, size, size);
    require(H5Dwrite(points, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, field.coordinates.data()),
            "write points (disk full?)");
    write_text(points, "field", field.name);
    write_text(points, "unit", field.unit);
  }
  /// The file that grew aside takes its place.
  ~Implementation() {
    if (n_rows == 0)
      std::remove(aside(file_name).c_str());
    else if (n_published > 0 || is_wanted)
      std::rename(aside(file_name).c_str(), file_name.c_str());
  }

  void show() {
    std::error_code error;
    const std::string copy = file_name + ".copy";
    std::filesystem::copy_file(aside(file_name), copy, std::filesystem::copy_options::overwrite_existing, error);
    if (error)
      throw Failure(ExitCode::file, "cannot write " + file_name + ": " + error.message() + " (disk full?)");
    publish(copy, file_name);
    n_published = n_rows;
  }

  void append(int step, double time, const std::vector<double> &row) {
    append_row<3>(values, H5T_NATIVE_DOUBLE, n_rows, {1, n_points, components}, row.data());
    append_row<1>(steps, H5T_NATIVE_INT, n_rows, {1}, &step);
    append_row<1>(times, H5T_NATIVE_DOUBLE, n_rows, {1}, &time);
    ++n_rows;
  }

  const std::string file_name;
  const hsize_t n_points, components;
  hsize_t n_rows = 0, n_published = 0;
  bool is_wanted = true;
  Hdf5Object file, values, steps, times;
};

RecordingWriter::RecordingWriter(const std::string &file_name, const RecordedField &field) {
  if (field.coordinates.empty())
    throw Failure(ExitCode::file, "recording " + file_name + ": field '" + field.name + "' has no points");
  salvage(file_name);
  implementation_ = std::make_unique<Implementation>(file_name, field);
}
RecordingWriter::~RecordingWriter() = default;
RecordingWriter::RecordingWriter(RecordingWriter &&) noexcept = default;

void RecordingWriter::keep(const RecordingReader &before, const RecordedField &field, double until) {
  const RecordedField &old = before.field();
  if (old.name != field.name || old.unit != field.unit || old.components != field.components)
    before.refuse("is of another field than " + field.name + " [" + field.unit + "], it cannot be gone on with");
  if (old.coordinates != field.coordinates)
    before.refuse("is of other points, it cannot be gone on with: give another file");
  const double same = 1e-9 * std::abs(until);
  const auto &times = before.times();
  for (std::size_t row = 0; row < times.size() && times[row] <= until + same; ++row)
    implementation_->append(before.steps()[row], times[row], before.values(row));
  if (times.empty() || times.back() < until - same)
    before.refuse("ends " + (times.empty() ? "at once" : "at t = " + std::to_string(times.back()) + " s") +
                  ", this run goes on from t = " + std::to_string(until) +
                  " s, so that a gap would remain: give another file");
}

void RecordingWriter::append(int step, double time, const std::vector<double> &values) {
  Implementation &to = *implementation_;
  if (values.size() != to.n_points * to.components)
    throw Failure(ExitCode::file, "recording " + to.file_name + ": " + std::to_string(values.size()) +
                                      " values instead of " + std::to_string(to.n_points * to.components));
  to.append(step, time, values);
  require(H5Fflush(to.file, H5F_SCOPE_LOCAL), "write the recording " + to.file_name + " (disk full?)");
}

/// When it has doubled, so that all copies together write no more than the recording has.
void RecordingWriter::show() {
  Implementation &all = *implementation_;
  if (all.n_rows > 0 && all.n_rows >= 2 * all.n_published)
    all.show();
}

void RecordingWriter::stay_aside() { implementation_->is_wanted = false; }

struct RecordingReader::Implementation {
  explicit Implementation(const std::string &file_name)
      : file_name(file_name), file(open_file(file_name, "open the recording " + file_name)),
        table(H5Dopen2(file, "values", H5P_DEFAULT), H5Dclose, "find values in the recording " + file_name),
        size(extent(table)), steps(read_all<int>(file, "step", H5T_NATIVE_INT)),
        times(read_all<double>(file, "time", H5T_NATIVE_DOUBLE)) {
    const Hdf5Object points(H5Dopen2(file, "points", H5P_DEFAULT), H5Dclose,
                            "find points in the recording " + file_name);
    require_all_stored(table, "values");
    field = {read_text(points, "field"), read_text(points, "unit"),
             size.size() == 3 ? static_cast<unsigned>(size[2]) : 0,
             read_all<double>(file, "points", H5T_NATIVE_DOUBLE)};
  }

  const std::string file_name;
  Hdf5Object file, table;
  std::vector<hsize_t> size; ///< transfers, points, components
  RecordedField field;
  std::vector<int> steps;
  std::vector<double> times;
};

RecordingReader::RecordingReader(const std::string &file_name)
    : implementation_(std::make_unique<Implementation>(file_name)) {
  check();
}
RecordingReader::~RecordingReader() = default;
RecordingReader::RecordingReader(RecordingReader &&) noexcept = default;

/// A run that was killed while it wrote leaves one row without step or time at most: what is complete counts.
void RecordingReader::check() {
  Implementation &all = *implementation_;
  const auto &coordinates = all.field.coordinates;
  if (all.size.size() != 3 || all.size[2] == 0 || all.size[2] > 1000)
    refuse("has no table of values [transfer][point][component]");
  if (coordinates.empty() || coordinates.size() % 3 != 0 || all.size[1] != coordinates.size() / 3)
    refuse("has values for " + std::to_string(all.size[1]) + " points, but " + std::to_string(coordinates.size()) +
           " coordinates, not three for each of them");
  const std::size_t n = std::min({std::size_t(all.size[0]), all.steps.size(), all.times.size()});
  all.steps.resize(n);
  all.times.resize(n);
  const auto finite = [](double x) { return std::isfinite(x); };
  if (!std::all_of(coordinates.begin(), coordinates.end(), finite))
    refuse("has a point whose coordinates are not finite");
  if (!std::all_of(all.times.begin(), all.times.end(), finite) || !std::is_sorted(all.times.begin(), all.times.end()) ||
      !std::is_sorted(all.steps.begin(), all.steps.end()))
    refuse("has times or steps that do not ascend");
}

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
  require(H5Dread(from.table, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, values.data()),
          "read the recording " + from.file_name + " at t = " + std::to_string(times()[transfer]) + " s (damaged?)");
  for (std::size_t k = 0; k < values.size(); ++k)
    if (!std::isfinite(values[k]))
      refuse("holds " + std::to_string(values[k]) + " at point " + std::to_string(k / from.size[2]) +
             ", t = " + std::to_string(times()[transfer]) + " s, where a finite number must be");
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
