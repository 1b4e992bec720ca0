#include "coupler/step_log.h"

#include <cmath>
#include <spdlog/fmt/fmt.h>

namespace heartbus::coupler {

namespace {

long milliseconds(double time) { return std::lround(std::floor(time * 1e3 + 1e-6)); }

std::string clock_time(double seconds) {
  const long s = std::lround(seconds);
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

} // namespace

StepLog::StepLog(std::shared_ptr<spdlog::logger> logger, const TimeControl &time, int last_step)
    : logger_(std::move(logger)), time_(time), last_step_(last_step) {}

void StepLog::step(const History &history, const bus::Step &step) {
  const bool new_millisecond = milliseconds(step.time) > milliseconds(step.time - step.size);
  if (!new_millisecond && step.number != time_.n_steps())
    return;
  const auto now = std::chrono::steady_clock::now();
  const double seconds = std::chrono::duration<double>(now - last_time_).count();
  logger_->info(line(history, step, seconds / (step.number - last_step_)));
  last_time_ = now;
  last_step_ = step.number;
}

std::string StepLog::line(const History &history, const bus::Step &step, double seconds_per_step) const {
  const auto &row = history.rows.back();
  const auto has = [&](const char *name) { return history.find(name) >= 0; };
  const auto value = [&](const char *name) { return row[history.find(name)]; };
  std::string text = fmt::format("{:7.1f} ms", step.time * 1e3);
  if (time_.n_beats() > 1)
    text = fmt::format("beat {} of {}  ", time_.beat(step.number), time_.n_beats()) + text;
  if (has("phase"))
    text += fmt::format("  {:25}", shown(history.columns[history.find("phase")], value("phase")));
  if (has("volume"))
    text += fmt::format("  V {:7.3f} mL", value("volume") * 1e6);
  if (has("mean_pressure"))
    text += fmt::format("  p {:7.2f} mmHg", value("mean_pressure") / 133.322387415);
  const std::string suffix = "_iterations";
  for (std::size_t c = 0; c < row.size(); ++c)
    if (const auto &name = history.columns[c].name;
        name.size() > suffix.size() && name.compare(name.size() - suffix.size(), std::string::npos, suffix) == 0)
      text += fmt::format("  {} {:g}", name.substr(0, name.size() - suffix.size()), row[c]);
  return text + fmt::format("  {:.3f} s/step  left {}", seconds_per_step,
                            clock_time((time_.n_steps() - step.number) * seconds_per_step));
}

} // namespace heartbus::coupler
