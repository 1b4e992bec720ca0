#pragma once

#include "coupler/time_control.h"

#include <string>
#include <vector>

namespace heartbus::coupler {

/// A complete set of states in its folder: one file for each physics, the history up to then, and manifest.json with
/// the size and checksum of each.
struct CheckpointSet {
  std::string folder;
  int step = 0;
  double time = 0, step_size = 0;       ///< [s], of the run that saved it
  std::vector<std::string> passed_over; ///< why newer sets cannot be used
};

/// The set that `--restart` means: "latest" of the results in `folder`, the one of a time such as "50 ms", or another
/// folder, either a set itself or results, whose latest counts. `latest` passes over sets that are damaged or
/// incomplete. Throws Failure(file) that says what is wrong.
CheckpointSet find_checkpoint(const std::string &choice, const std::string &folder);

/// Saves the sets of a run, RESULTS/checkpoints/000240 and so on, and keeps the last ones. A set is written aside and
/// renamed when it is complete.
class Checkpoints {
 public:
  Checkpoints(const std::string &results, const CheckpointParameters &parameters, const TimeControl &time);

  bool due(int step_number) const;
  /// The folder into which the states of this step go.
  std::string open(const bus::Step &step) const;
  /// All states and the history are there.
  void close(const bus::Step &step) const;
  /// Forgets what comes after this step, which a restarted run is about to do again.
  void remove_after(int step_number) const;

 private:
  std::string set_folder(int step_number) const;
  std::string results_;
  CheckpointParameters parameters_;
  TimeControl time_;
};

} // namespace heartbus::coupler
