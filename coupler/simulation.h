#pragma once

#include "common/io/recording.h"
#include "coupler/checkpoints.h"
#include "coupler/file_lock.h"
#include "coupler/history.h"
#include "coupler/options.h"
#include "coupler/sequence/sequence_runner.h"
#include "coupler/sequence/time_control.h"

#include <memory>
#include <nlohmann/json.hpp>
#include <spdlog/logger.h>

namespace heartbus::coupler {

/// One run: handshake, start block or checkpoint, steps, results. It must outlive the coordinator's run, because the
/// last values to be recorded may arrive when its own `run` has returned.
class Simulation {
 public:
  Simulation(bus::Coordinator &coordinator, const Options &options);
  ~Simulation();
  void run();

 private:
  Sequence meet_participants();
  void make_columns();
  void record(const SequenceRunner &runner);
  std::unique_ptr<io::RecordingWriter> open_recording(const std::string &file, const io::RecordedField &field) const;
  bus::Step begin(SequenceRunner &runner, const TimeControl &time);
  bus::Step restart(SequenceRunner &runner, const TimeControl &time);
  /// All steps to the end, or to where the run is stopped or has become periodic.
  void steps(SequenceRunner &runner, const TimeControl &time, int number, Checkpoints &checkpoints, HistoryFile &csv);
  void save(SequenceRunner &runner, Checkpoints &checkpoints, const bus::Step &step);
  void add_times(const SequenceRunner::Reports &reports);
  void collect(const SequenceRunner::Reports &reports, const bus::Step &step);
  void begin_trace();
  void advance(SequenceRunner &runner, const TimeControl &time, int number, bool pauses);
  void end_trace();
  bool is_periodic() const;
  void tell_changes() const; ///< whether the beats became periodic, if that was asked for
  void print_numbers(const nlohmann::ordered_json &result) const;
  void add_costs(nlohmann::ordered_json &result) const;
  void write_indicators(std::size_t n_steps, double wall_seconds) const;

  bus::Coordinator &coordinator_;
  Options options_;
  SceneParameters scene_;
  std::string folder_;
  FileLock lock_; ///< of the folder
  std::optional<CheckpointSet> restart_;
  std::shared_ptr<spdlog::logger> log_;
  History history_;
  std::map<std::string, bus::Times> times_;              ///< of the steps
  SequenceRunner::Reports first_reports_, last_reports_; ///< before the first and after the last step
  std::vector<std::unique_ptr<io::RecordingWriter>> recordings_;
  std::optional<bus::Trace> trace_; ///< of the coupler
  bool ended_well_ = false;
};

} // namespace heartbus::coupler
