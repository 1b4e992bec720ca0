#include "coupler/trace_file.h"

#include "common/base/failure.h"

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

namespace heartbus::coupler {
namespace {

using nlohmann::ordered_json;

/// Names of a process (participant) and of a row within it (rank).
ordered_json name_event(const char *what, int participant, int rank, const std::string &name) {
  return {{"ph", "M"}, {"name", what}, {"pid", participant}, {"tid", rank}, {"args", {{"name", name}}}};
}

/// Rounded such that what is contained remains contained.
ordered_json slice_event(const bus::Slice &slice, const std::string &name, double origin, int participant, int rank) {
  const auto nanoseconds = [origin](double time) { return std::llround(1e9 * (time + origin)); };
  const long long begin = nanoseconds(slice.begin), end = nanoseconds(slice.end);
  return {{"ph", "X"},
          {"name", name},
          {"pid", participant},
          {"tid", rank},
          {"ts", 1e-3 * begin},
          {"dur", 1e-3 * (end - begin)},
          {"args", {{"step", slice.step}, {"iteration", slice.iteration}}}};
}

/// Of all ranks, on the common clock.
double first_begin(const std::vector<bus::Coordinator::RankTrace> &traces) {
  double first = std::numeric_limits<double>::max();
  for (const auto &of_rank : traces)
    for (const bus::Slice &slice : of_rank.trace.slices)
      first = std::min(first, slice.begin + of_rank.trace.clock_origin);
  return first;
}

} // namespace

void write_trace(const std::string &file_name, const std::vector<bus::Coordinator::RankTrace> &traces) {
  std::ofstream file(file_name);
  std::set<std::string> names;
  for (const auto &of_rank : traces)
    names.insert(of_rank.participant);
  const double first = first_begin(traces);
  const char *separator = "{\"traceEvents\": [\n";
  const auto write = [&](const ordered_json &event) {
    file << separator << event.dump();
    separator = ",\n";
  };
  for (const auto &[participant, rank, trace] : traces) {
    const int process = int(std::distance(names.begin(), names.find(participant)));
    const std::string dropped =
        trace.n_dropped > 0 ? ", " + std::to_string(trace.n_dropped) + " later slices left out" : "";
    write(name_event("process_name", process, rank, participant));
    write(name_event("thread_name", process, rank, "rank " + std::to_string(rank) + dropped));
    for (const bus::Slice &slice : trace.slices)
      write(slice_event(slice, trace.names[slice.name], trace.clock_origin - first, process, rank));
  }
  file << "\n]}\n";
  if (!file.flush())
    throw Failure(ExitCode::file, file_name + ": cannot be written");
}

} // namespace heartbus::coupler
