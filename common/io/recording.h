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
/// `values` [transfer][point][component], `step` and `time` [s] [transfer]. It grows as FILE.part, which is complete
/// after every append, and becomes FILE at the end. A recording of that name stays what it is until then or the first
/// `show`, and whoever has it open keeps it. What a run that was killed left as FILE.part becomes FILE when the next
/// one records there, if it came farther. Errors are Failure(file).
class RecordingReader;
class RecordingWriter {
 public:
  RecordingWriter(const std::string &file_name, const RecordedField &field);
  /// Takes over what was recorded up to this time [s]. Failure(file) when that is another field, or of other points, or
  /// ends before.
  void keep(const RecordingReader &before, const RecordedField &field, double until);
  ~RecordingWriter();
  RecordingWriter(RecordingWriter &&) noexcept;
  void append(int step, double time, const std::vector<double> &values);
  /// FILE becomes a copy of what there is, now and then, for readers, who must not see a file that grows.
  void show();
  /// The run fails: FILE.part does not become FILE unless it was shown before.
  void stay_aside();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Failure(file) when the tables do not fit each other or hold what is no finite number.
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
  [[noreturn]] void refuse(const std::string &what) const;

 private:
  void check();
  /// Number of the k-th transfer of the step that the transfer `any` belongs to.
  std::size_t transfer_of(std::size_t any, int k) const;
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace heartbus::io
