#include "common/bus/trace.h"

#include <algorithm>

namespace heartbus::bus {
namespace {

template <class Time>
double seconds(const Time &time) {
  return std::chrono::duration<double>(time.time_since_epoch()).count();
}

} // namespace

/// Of all clocks only the system's is the same in all processes, but it may be set; the steady one is good for spans.
Trace::Trace() : clock_origin(seconds(std::chrono::system_clock::now()) - seconds(std::chrono::steady_clock::now())) {}

void Trace::add(std::string_view name, Stopwatch::Time begin, Stopwatch::Time end, const Step &step) {
  if (slices.size() == most_slices) {
    ++n_dropped;
    return;
  }
  const auto known = std::find(names.begin(), names.end(), name);
  const int number = known - names.begin();
  if (known == names.end())
    names.emplace_back(name);
  slices.push_back({number, seconds(begin), seconds(end), step.number, step.iteration});
}

Packer &operator<<(Packer &packer, const Trace &trace) {
  return packer << trace.clock_origin << trace.n_dropped << trace.names << trace.slices;
}

Unpacker &operator>>(Unpacker &unpacker, Trace &trace) {
  return unpacker >> trace.clock_origin >> trace.n_dropped >> trace.names >> trace.slices;
}

} // namespace heartbus::bus
