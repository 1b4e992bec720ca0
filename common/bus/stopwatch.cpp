#include "common/bus/stopwatch.h"

namespace heartbus::bus {

void add(const Seconds &more, Seconds &sums) {
  for (const auto &[name, seconds] : more)
    sums[name] += seconds;
}

double total(const Seconds &seconds) {
  double sum = 0;
  for (const auto &part : seconds)
    sum += part.second;
  return sum;
}

Stopwatch::Time Stopwatch::change_to(const std::string &part) {
  const Time now = std::chrono::steady_clock::now();
  if (!part_.empty())
    seconds_[part_] += std::chrono::duration<double>(now - since_).count();
  part_ = part;
  since_ = now;
  return now;
}

Stopwatch::Section::~Section() {
  const std::string part = stopwatch_.part_;
  const Time end = stopwatch_.change_to(outer_);
  if (stopwatch_.on_section)
    stopwatch_.on_section(part, begin_, end);
}

Seconds Stopwatch::take() {
  change_to(part_);
  Seconds seconds;
  seconds.swap(seconds_);
  return seconds;
}

} // namespace heartbus::bus
