#include "common/bus/trace.h"

namespace heartbus::bus {
namespace {

template <class Time>
double seconds(const Time &time) {
  return std::chrono::duration<double>(time.time_since_epoch()).count();
}

} // namespace

/// Of all clocks only the system's is the same in all processes, but it may be set; the steady one is good for spans.
Trace::Trace() : clock_origin(seconds(std::chrono::system_clock::now()) - seconds(std::chrono::steady_clock::now())) {}

void Trace::add(const std::string &name, Stopwatch::Time begin, Stopwatch::Time end, const Step &step) {
  if (slices.size() < most_slices)
    slices.push_back({name, seconds(begin), seconds(end), step.number, step.iteration});
  else
    ++n_dropped;
}

Packer &operator<<(Packer &packer, const Trace &trace) {
  packer << trace.clock_origin << trace.n_dropped << trace.slices.size();
  for (const Slice &slice : trace.slices)
    packer << slice.name << slice.begin << slice.end << slice.step << slice.iteration;
  return packer;
}

Unpacker &operator>>(Unpacker &unpacker, Trace &trace) {
  unpacker >> trace.clock_origin >> trace.n_dropped;
  trace.slices.resize(unpacker.read<std::size_t>());
  for (Slice &slice : trace.slices)
    unpacker >> slice.name >> slice.begin >> slice.end >> slice.step >> slice.iteration;
  return unpacker;
}

} // namespace heartbus::bus
