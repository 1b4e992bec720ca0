#pragma once

#include "common/bus/solver.h"
#include "common/io/recording.h"

#include <mpi.h>
#include <string>
#include <vector>

namespace heartbus::replay {

/// Plays a recorded field in place of the participant that has computed it: electrophysiology once, then many runs of
/// the mechanics with its calcium. The k-th solve of a step puts out what has been sent k-th in that step, with the
/// same bits if the run has the steps of the recording; with other steps, values are linear in time between recorded
/// ones.
class Player : public bus::Solver {
 public:
  Player(MPI_Comm communicator, const std::string &file_name);
  void declare(bus::Declaration &declaration) override;
  void prepare_step(const bus::Step &) override {}
  void solve_step(const bus::Step &step) override;
  void commit_step(const bus::Step &) override {}

 private:
  const io::RecordingReader recording_;
  std::size_t first_ = 0, last_ = 0; ///< points of this rank: an even share
  std::vector<double> values_;
};

} // namespace heartbus::replay
