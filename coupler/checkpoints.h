#pragma once

#include "coupler/file_lock.h"
#include "coupler/manifest.h"
#include "coupler/sequence/time_control.h"
#include "scene/scene.h"

#include <memory>
#include <set>
#include <string>
#include <vector>

namespace heartbus::coupler {

/// A complete set of states in its folder: one file for each physics, the history up to then, and the manifest.
struct CheckpointSet {
  std::string folder;
  Manifest manifest;
  std::vector<std::string> passed_over; ///< why newer sets cannot be used
  std::shared_ptr<FileLock> reading;    ///< while it is held nobody removes the set, this run included
};

/// The set that `--restart` means: "latest" of the results in `folder`, the one of a time such as "50 ms", or another
/// folder, either a set itself or results, whose latest counts. `latest` and times pass over what is damaged,
/// incomplete or no set at all. Throws Failure(file) that says what is wrong, or in what the state differs from the
/// scene.
CheckpointSet find_checkpoint(const std::string &choice, const std::string &folder, const SceneParameters &scene);

/// Saves the sets of a run, RESULTS/checkpoints/000240 and so on, and keeps the last ones. A set is written aside,
/// 000240.part, and renamed when it is complete. What other runs left stays until this run has a complete set of its
/// own; then it goes to RESULTS/checkpoints.old, and what was there before goes for good. What somebody reads stays.
class Checkpoints {
 public:
  /// `from`: where the run went on from; null when it began at the start.
  Checkpoints(const std::string &results, const SceneParameters &scene, const CheckpointSet *from);

  bool due(int step_number) const;
  /// The folder into which the states of this step go.
  std::string open(const bus::Step &step) const;
  /// All states and the history are there.
  void close(const bus::Step &step);

 private:
  bool is_own(int step_number) const;
  void set_others_aside() const;

  std::string results_;
  CheckpointParameters parameters_;
  std::map<std::string, std::string> model_;
  TimeControl time_;
  int last_before_ = -1;      ///< of the sets of these results, the step that this run goes on from
  std::set<int> own_numbers_; ///< of the sets of this run
};

} // namespace heartbus::coupler
