// The coupler of the tests: "a" solves and sends its signal to "b", which checks every value, twice in every step.
// Arguments: number of steps, their size [s], deadline [s], then optionally what is done wrong (see dummy.cpp), who
// does it, and the file of a recording. "record coupler FILE" writes one, "replay a FILE" lets the program replay play
// "a".
#include "common/base/failure.h"
#include "common/bus/coordinator.h"
#include "common/io/recording.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <mpi.h>

namespace {

using namespace heartbus;
using Kind = bus::Command::Kind;

/// The coupler listens to the route, checks what it hears and writes it down when there is a file for it.
class Listener {
 public:
  Listener(bus::Coordinator &bus, int route, const std::string &file) {
    const auto heard = bus.record(route, [this](const auto &step, const auto &values) { hear(step, values); });
    points_ = heard.coordinates;
    if (!file.empty())
      writer_ = std::make_unique<io::RecordingWriter>(
          file, io::RecordedField{"signal", heard.unit, heard.components, heard.coordinates});
  }
  int n_heard() const { return n_heard_; }

 private:
  void hear(const bus::Step &step, const std::vector<double> &values) {
    for (std::size_t i = 0; i < points_.size() / 3; ++i)
      if (std::abs(values[2 * i] - points_[3 * i] - step.number) > 1e-9)
        throw Failure(ExitCode::map, "the coupler has heard a wrong value");
    if (writer_)
      writer_->append(step.number, step.time, values);
    ++n_heard_;
  }
  int n_heard_ = 0;
  std::vector<double> points_;
  std::unique_ptr<io::RecordingWriter> writer_;
};

void run_step(bus::Coordinator &bus, int route, bus::Step step, bool forgets_to_send) {
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

bus::Report ask(bus::Coordinator &bus, const std::string &name) {
  bus.order(name, {Kind::report, "", -1, {}});
  bus.flush();
  return bus.wait_report(name);
}

} // namespace

int main(int argc, char **argv) {
  bus::Coordinator bus;
  return bus.run([&] {
    const int n_steps = std::atoi(argv[1]);
    const double dt = std::atof(argv[2]), deadline = std::atof(argv[3]);
    const std::string mischief = argc > 5 ? argv[4] : "none", who = argc > 5 ? argv[5] : "nobody";
    const std::string file = argc > 6 ? argv[6] : "";
    if (mischief == "fail" && who == "coupler")
      throw Failure(ExitCode::scene, "the scene is wrong");

    const bool replay = mischief == "replay";
    using Expected = bus::Coordinator::Expected;
    const Expected player = replay ? Expected{"replay", 0, {{"file", file}}} : Expected{"coupling_dummy"};
    bus.handshake({{"a", player}, {"b", {"coupling_dummy"}}}, "# " + mischief + " " + who, "/tmp", deadline);
    const int route = bus.connect("a", "b", mischief == "unknown_field" ? "sound" : "signal");
    const Listener listener(bus, route, mischief == "record" ? file : "");
    const double cpu_before = ask(bus, "b").cpu_seconds;
    bus::Report a, b;
    double longest = 0; // step [s]
    for (bus::Step step{1, 0, dt, dt}; step.number <= n_steps; step.time = ++step.number * dt) {
      const double begin = MPI_Wtime();
      run_step(bus, route, step, mischief == "forget");
      a = bus.wait_report("a");
      b = bus.wait_report("b");
      longest = std::max(longest, MPI_Wtime() - begin);
    }
    std::printf("%g waits overslept, longest step %.1f ms\n", a.n_overslept + b.n_overslept + bus.n_overslept(),
                1e3 * longest);
    std::printf("b received for %g s and used %g CPU s in all\n", b.times.commands.at("receive"),
                b.cpu_seconds - cpu_before);
    if (!replay) {
      std::printf("a was prepared %g times, phase of b is %g\n", a.scalars.at(0), b.scalars.at(1));
      std::printf("lowest %g, highest %g, unknown %g, ranks %g\n", a.scalars.at(2), a.scalars.at(3), a.scalars.at(4),
                  a.scalars.at(5));
    }
    std::printf("coupler heard %d transfers\n", listener.n_heard());
  });
}
