#pragma once

#include <memory>
#include <string>
#include <vector>

namespace heartbus::io {

/// A nodal field as it travels between participants, keyed by its points and so independent of meshes and ranks.
struct RecordedField {
  std::string name, unit;
  unsigned components = 1;
  std::vector<double> coordinates; ///< three for each point [m]
};

/// What has been sent in time, in one HDF5 file: `points` [point][3] [m] with the attributes `field` and `unit`;
/// `values` [transfer][point][component], `step` and `time` [s] [transfer]. Complete after every append, so that the
/// recording of an interrupted run can be used. Errors are Failure(file).
class RecordingWriter {
 public:
  RecordingWriter(const std::string &file_name, const RecordedField &field);
  ~RecordingWriter();
  RecordingWriter(RecordingWriter &&) noexcept;
  void append(int step, double time, const std::vector<double> &values);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

class RecordingReader {
 public:
  explicit RecordingReader(const std::string &file_name);
  ~RecordingReader();
  RecordingReader(RecordingReader &&) noexcept;

  const RecordedField &field() const;
  const std::vector<int> &steps() const;    ///< of every transfer, ascending; several may belong to one step
  const std::vector<double> &times() const; ///< [s]
  std::vector<double> values(std::size_t transfer) const;

  /// What was sent by the k-th transfer (0-based) of a step at this time [s]; linear in time between recorded steps,
  /// the first values during the step before the first. Failure(file) outside of the recording.
  std::vector<double> values_at(double time, int k) const;

 private:
  /// Number of the k-th transfer of the step that the transfer `any` belongs to.
  std::size_t transfer_of(std::size_t any, int k) const;
  [[noreturn]] void refuse(const std::string &what) const;
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace heartbus::io
