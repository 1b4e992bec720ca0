#pragma once

#include "coupler/history.h"
#include "coupler/sequence/time_control.h"

#include <chrono>
#include <memory>
#include <spdlog/logger.h>

namespace heartbus::coupler {

/// A logger for the log alone, not for the terminal.
std::shared_ptr<spdlog::logger> for_the_file(const spdlog::logger &logger);

/// Where the run is: a line for each 10 ms of simulated time, of runs shorter than 100 ms for each. Under a launcher
/// with a terminal (HEARTBUS_LIVE) these go to the log alone; the terminal gets, ten times a second, a line that
/// begins with a tab, of the share of steps done and parts between tabs, which the launcher renews in place.
class StepLog {
 public:
  StepLog(std::shared_ptr<spdlog::logger> logger, const TimeControl &time, int last_step);
  /// After every step; `history` ends with it.
  void step(const History &history, const bus::Step &step);

 private:
  using Clock = std::chrono::steady_clock;
  struct Parts {
    std::string when, phase, blood, iterations, pace, left;
  };
  bool is_due(const bus::Step &step) const;
  void show(const History &history, const bus::Step &step);
  Parts told(const History &history, const bus::Step &step, double seconds_per_step) const;
  std::string line(const History &history, const bus::Step &step, double seconds_per_step) const;

  std::shared_ptr<spdlog::logger> logger_;
  TimeControl time_;
  bool is_live_;
  int last_step_, shown_step_;
  double shown_pace_ = 0; ///< of the terminal's line, smoothed [s a step]
  Clock::time_point last_time_ = Clock::now(), shown_ = last_time_;
};

} // namespace heartbus::coupler
