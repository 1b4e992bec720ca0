#include "common/base/stopwatch.h"

#include <algorithm>
#include <utility>

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

int Stopwatch::number_of(std::string_view name) {
  const auto found = std::find_if(parts_.begin(), parts_.end(), [&](const Part &part) { return part.name == name; });
  const int number = found - parts_.begin();
  if (found == parts_.end())
    parts_.push_back({std::string(name)});
  return number;
}

Stopwatch::Time Stopwatch::change_to(int part) {
  const Time now = std::chrono::steady_clock::now();
  if (open_ != none) {
    parts_[open_].seconds += std::chrono::duration<double>(now - since_).count();
    parts_[open_].counted = true;
  }
  open_ = part;
  since_ = now;
  return now;
}

Stopwatch::Section::~Section() {
  const int part = stopwatch_.open_;
  const Time end = stopwatch_.change_to(outer_);
  if (stopwatch_.on_section)
    stopwatch_.on_section(stopwatch_.parts_[part].name, begin_, end);
}

Seconds Stopwatch::take() {
  change_to(open_);
  Seconds seconds;
  for (Part &part : parts_)
    if (std::exchange(part.counted, false))
      seconds[part.name] = std::exchange(part.seconds, 0.);
  return seconds;
}

} // namespace heartbus::bus
