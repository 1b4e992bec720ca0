#pragma once

#include "common/io/recording.h"
#include "coupler/checkpoints.h"
#include "coupler/history.h"
#include "coupler/options.h"
#include "coupler/sequence/sequence_runner.h"
#include "coupler/time_control.h"

#include <memory>
#include <spdlog/logger.h>

namespace heartbus::coupler {

/// One run: handshake, start block or checkpoint, steps, results. It must outlive the coordinator's run, because the
/// last values to be recorded may arrive when its own `run` has returned.
class Simulation {
 public:
  Simulation(bus::Coordinator &coordinator, const Options &options);
  void run();

 private:
  Sequence meet_participants();
  void make_columns();
  void record(const SequenceRunner &runner);
  bus::Step begin(SequenceRunner &runner, const TimeControl &time);
  bus::Step restart(SequenceRunner &runner, const TimeControl &time);
  void save(SequenceRunner &runner, const Checkpoints &checkpoints, const bus::Step &step);
  void add_times(const SequenceRunner::Reports &reports);
  void collect(const SequenceRunner::Reports &reports, const bus::Step &step);
  void write_indicators(double wall_seconds) const;

  bus::Coordinator &coordinator_;
  Options options_;
  SceneParameters scene_;
  std::optional<CheckpointSet> restart_;
  std::string folder_;
  std::shared_ptr<spdlog::logger> log_;
  History history_;
  std::map<std::string, std::map<std::string, double>> seconds_; ///< [participant][kind of work]
  SequenceRunner::Reports last_reports_;
  std::vector<std::unique_ptr<io::RecordingWriter>> recordings_;
};

} // namespace heartbus::coupler
