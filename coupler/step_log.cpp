#include "coupler/step_log.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <spdlog/fmt/fmt.h>

namespace heartbus::coupler {

namespace {

long whole(double time, double interval) { return std::lround(std::floor(time / interval + 1e-6)); }

std::string clock_time(double seconds) {
  const long s = std::lround(seconds);
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

} // namespace

std::shared_ptr<spdlog::logger> for_the_file(const spdlog::logger &logger) {
  auto alone = std::make_shared<spdlog::logger>(logger.name(), logger.sinks().front());
  alone->flush_on(spdlog::level::info);
  return alone;
}

StepLog::StepLog(std::shared_ptr<spdlog::logger> logger, const TimeControl &time, int last_step)
    : logger_(std::move(logger)), time_(time), is_live_(std::getenv("HEARTBUS_LIVE") != nullptr), last_step_(last_step),
      shown_step_(last_step) {
  if (is_live_)
    logger_ = for_the_file(*logger_);
}

bool StepLog::is_due(const bus::Step &step) const {
  const double interval = time_.step(time_.n_steps()).time < 0.1 ? 1e-3 : 10e-3;
  return step.number == time_.n_steps() || whole(step.time, interval) > whole(step.time - step.size, interval);
}

void StepLog::step(const History &history, const bus::Step &step) {
  if (is_live_)
    show(history, step);
  if (!is_due(step))
    return;
  const auto now = Clock::now();
  const double seconds = std::chrono::duration<double>(now - last_time_).count();
  logger_->info(line(history, step, seconds / (step.number - last_step_)));
  last_time_ = now;
  last_step_ = step.number;
}

/// What matters most comes first, since a terminal may be narrow.
void StepLog::show(const History &history, const bus::Step &step) {
  const double seconds = std::chrono::duration<double>(Clock::now() - shown_).count();
  if (seconds < 0.1 && step.number != time_.n_steps())
    return;
  const double pace = seconds / (step.number - shown_step_);
  shown_pace_ = shown_pace_ > 0 ? 0.9 * shown_pace_ + 0.1 * pace : pace;
  const Parts parts = told(history, step, shown_pace_);
  std::printf("\t%.4f\t%s\t%s\t%s\t%s\t%s\t%s\n", double(step.number) / time_.n_steps(), parts.left.c_str(),
              parts.when.c_str(), parts.phase.c_str(), parts.blood.c_str(), parts.pace.c_str(),
              parts.iterations.c_str());
  std::fflush(stdout);
  shown_ = Clock::now();
  shown_step_ = step.number;
}

std::string StepLog::line(const History &history, const bus::Step &step, double seconds_per_step) const {
  const Parts parts = told(history, step, seconds_per_step);
  return parts.when + (parts.phase.empty() ? "" : fmt::format("  {:25}", parts.phase)) +
         (parts.blood.empty() ? "" : "  " + parts.blood) + "  " + parts.iterations + "  " + parts.pace + "  " +
         parts.left;
}

StepLog::Parts StepLog::told(const History &history, const bus::Step &step, double seconds_per_step) const {
  const auto &row = history.rows.back();
  const auto has = [&](const char *name) { return history.find(name) >= 0; };
  const auto value = [&](const char *name) { return row[history.find(name)]; };
  const auto add = [](std::string &text, const std::string &more) { text += (text.empty() ? "" : "  ") + more; };
  Parts parts;
  if (time_.n_beats() > 1)
    add(parts.when, fmt::format("beat {} of {}", time_.beat(step.number), time_.n_beats()));
  add(parts.when, fmt::format("{:7.1f} ms", step.time * 1e3));
  if (has("phase"))
    parts.phase = shown(history.columns[history.find("phase")], value("phase"));
  if (has("volume"))
    add(parts.blood, fmt::format("V {:7.3f} mL", value("volume") * 1e6));
  if (has("mean_pressure"))
    add(parts.blood, fmt::format("p {:7.2f} mmHg", value("mean_pressure") / 133.322387415));
  const std::string suffix = "_iterations";
  for (std::size_t c = 0; c < row.size(); ++c)
    if (const auto &name = history.columns[c].name;
        name.size() > suffix.size() && name.compare(name.size() - suffix.size(), std::string::npos, suffix) == 0)
      add(parts.iterations, fmt::format("{} {:g}", name.substr(0, name.size() - suffix.size()), row[c]));
  parts.pace = fmt::format("{:.1f} ms/step", 1e3 * seconds_per_step);
  parts.left = "left " + clock_time((time_.n_steps() - step.number) * seconds_per_step);
  return parts;
}

} // namespace heartbus::coupler
