// The coupler of the tests: "a" solves and sends its signal to "b", which checks every value, twice in every step.
// Arguments: number of steps, deadline [s], and the words of the scene (see dummy.cpp).
#include "common/bus/coordinator.h"
#include "common/bus/failure.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace {

using namespace heartbus;
using Kind = bus::Command::Kind;

void record(bus::Coordinator &bus, int route, int &n_recorded) {
  auto points = std::make_shared<std::vector<double>>();
  *points = bus.record(route, [points, &n_recorded](const bus::Step &step, const std::vector<double> &values) {
                 for (std::size_t i = 0; i < points->size() / 3; ++i)
                   if (std::abs(values[2 * i] - (*points)[3 * i] - step.number) > 1e-9)
                     throw Failure(ExitCode::map, "a wrong value has been recorded");
                 ++n_recorded;
               }).coordinates;
}

void run_step(bus::Coordinator &bus, int route, bus::Step step, bool forgets_to_send) {
  bus.order("a", {Kind::prepare, "", -1, step});
  for (step.iteration = 0; step.iteration < 2; ++step.iteration) {
    bus.order("a", {Kind::solve, "", -1, step});
    if (!forgets_to_send)
      bus.order("a", {Kind::send, "", route, step});
    bus.order("b", {Kind::receive, "", route, step});
    bus.order("b", {Kind::task, "check", -1, step});
  }
  for (const std::string name : {"a", "b"}) {
    bus.order(name, {Kind::commit, "", -1, step});
    bus.order(name, {Kind::report, "", -1, step});
  }
  bus.flush();
}

} // namespace

int main(int argc, char **argv) {
  bus::Coordinator bus(argc, argv);
  return bus.run([&] {
    const int n_steps = std::atoi(argv[1]);
    const std::string mischief = argc > 3 ? argv[3] : "none", who = argc > 4 ? argv[4] : "nobody";
    if (mischief == "fail" && who == "coupler")
      throw Failure(ExitCode::scene, "the scene is wrong");
    bus.handshake({{"a", {"coupling_dummy"}}, {"b", {"coupling_dummy"}}}, mischief + " " + who, "/tmp",
                  std::atof(argv[2]));
    const int route = bus.connect("a", "b", mischief == "unknown_field" ? "sound" : "signal");
    int n_recorded = 0;
    record(bus, route, n_recorded);
    bus::Report report;
    for (bus::Step step{1, 0, 0.1, 0.1}; step.number <= n_steps; ++step.number, step.time += step.size) {
      run_step(bus, route, step, mischief == "forget" && who == "coupler");
      report = bus.wait_report("a");
      const bus::Report other = bus.wait_report("b");
      std::printf("step %d: a prepared %g, phase of b %g, b received for %g s with %g CPU s\n", step.number,
                  report.scalars.at(0), other.scalars.at(1), other.seconds.at("receive"), other.cpu_seconds);
    }
    std::printf("coupler: recorded %d, idle %g s, memory %g MB\n", n_recorded, report.seconds.at("idle"),
                report.peak_memory / 1e6);
  });
}
