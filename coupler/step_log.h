#pragma once

#include "coupler/history.h"
#include "coupler/time_control.h"

#include <chrono>
#include <memory>
#include <spdlog/logger.h>

namespace heartbus::coupler {

/// One line on the console for each millisecond of simulated time.
class StepLog {
 public:
  StepLog(std::shared_ptr<spdlog::logger> logger, const TimeControl &time, int last_step);
  /// After every step; `history` ends with it.
  void step(const History &history, const bus::Step &step);

 private:
  std::string line(const History &history, const bus::Step &step, double seconds_per_step) const;

  std::shared_ptr<spdlog::logger> logger_;
  TimeControl time_;
  int last_step_;
  std::chrono::steady_clock::time_point last_time_ = std::chrono::steady_clock::now();
};

} // namespace heartbus::coupler
