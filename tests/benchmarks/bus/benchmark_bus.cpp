// Both directions of a field between two participants, by the bus and by bare MPI in the same launch:
//   p=build/release/bin/benchmark_bus; mpirun -n 1 $p : -n 2 $p --name a : -n 2 $p --name b
//
// echo.c and echo.py are the same participants through the interfaces of C and Python, without bare MPI; compare.py
// runs all three in turn. Whoever has received is told to solve, so that each trip passes through the participant's own
// code.
//
// The participants hold the same points, differently distributed and in different orders, as two meshes do. Bare MPI
// sends two messages each way, between ranks of the same place, with nothing to reorder.
#include "common/bus/coordinator.h"
#include "common/bus/participant.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <mpi.h>

namespace {

using namespace heartbus;
using Kind = bus::Command::Kind;

const std::vector<int> sizes = {1000, 10000, 100000}; // vectors of three components
constexpr int n_trips = 20;                           // in one go

std::string field_name(int size) { return "field_" + std::to_string(size); }

/// Holds points and fields of all sizes; "echo" leaves what has been received in what is sent.
class Dummy : public bus::Solver {
 public:
  explicit Dummy(const bus::Participant &participant) : is_a_(participant.name() == "a") {
    MPI_Comm_rank(participant.communicator(), &rank_);
  }

  void declare(bus::Declaration &bus) override {
    for (std::size_t s = 0; s < sizes.size(); ++s) {
      const int size = sizes[s], split = is_a_ ? size / 2 : size / 3;
      for (int i = rank_ == 0 ? 0 : split; i < (rank_ == 0 ? split : size); ++i) {
        const int p = is_a_ ? i : size - 1 - i;
        points_[s].insert(points_[s].end(), {1e-3 * (p % 50), 1e-3 * (p / 50 % 50), 1e-3 * (p / 2500)});
      }
      sent_[s] = received_[s] = points_[s];
      const std::string set = "points_" + std::to_string(size);
      bus.point_set(set, points_[s], 1e-3);
      bus.output(field_name(size), set, 3, "m", "n", sent_[s]);
      bus.input(field_name(size), set, 3, "m", received_[s]);
    }
    bus.task("start", [this](const bus::Step &) { start_ = MPI_Wtime(); });
    bus.task("stop", [this](const bus::Step &) { seconds_ = MPI_Wtime() - start_; });
    bus.task("bare", [this](const bus::Step &step) { send_bare(sizes[step.number]); });
    bus.scalar("seconds", "s", [this] { return seconds_; });
  }

  void prepare_step(const bus::Step &) override {}
  void solve_step(const bus::Step &) override {}
  void commit_step(const bus::Step &) override {}

 private:
  /// Ranks 1 and 2 of the launch are a's, 3 and 4 b's.
  void send_bare(int size) {
    std::vector<double> data(3 * (size / 2));
    int world_rank = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &world_rank);
    const int partner = is_a_ ? world_rank + 2 : world_rank - 2;
    const double start = MPI_Wtime();
    for (int trip = 0; trip < n_trips; ++trip)
      for (const bool sends : {is_a_, !is_a_})
        if (sends)
          MPI_Send(data.data(), int(data.size()), MPI_DOUBLE, partner, 7, MPI_COMM_WORLD);
        else
          MPI_Recv(data.data(), int(data.size()), MPI_DOUBLE, partner, 7, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    seconds_ = MPI_Wtime() - start;
  }

  bool is_a_;
  int rank_ = 0;
  double start_ = 0, seconds_ = 0;
  std::vector<double> points_[3], sent_[3], received_[3];
};

/// Median of what a task between "start" and "stop" takes in `a` [us a trip].
template <class Commands>
double median(bus::Coordinator &bus, const Commands &commands) {
  std::vector<double> times;
  for (int repetition = 0; repetition < 31; ++repetition) {
    commands();
    for (const std::string name : {"a", "b"})
      bus.order(name, {Kind::report, "", -1, {}});
    bus.flush();
    times.push_back(1e6 / n_trips * bus.wait_report("a").scalars.at(0));
    bus.wait_report("b");
  }
  std::nth_element(times.begin(), times.begin() + times.size() / 2, times.end());
  return times[times.size() / 2];
}

void measure(bus::Coordinator &bus) {
  const std::string program = "benchmark_bus";
  bus.handshake({{"a", {program, 2}}, {"b", {program, 2}}}, "", "/tmp", 60);
  std::printf("both directions of vectors with three components, 2 + 2 ranks, medians\n");
  std::printf("%8s %12s %16s %8s\n", "vectors", "bus [us]", "bare MPI [us]", "ratio");
  for (int s = 0; s < int(sizes.size()); ++s) {
    const int there = bus.connect("a", "b", field_name(sizes[s])), back = bus.connect("b", "a", field_name(sizes[s]));
    const bus::Step step{s, 0, 0, 0};
    const double by_bus = median(bus, [&] {
      bus.order("a", {Kind::task, "start", -1, step});
      for (int trip = 0; trip < n_trips; ++trip) {
        bus.order("a", {Kind::send, "", there, step});
        bus.order("b", {Kind::receive, "", there, step});
        bus.order("b", {Kind::solve, "", -1, step});
        bus.order("b", {Kind::send, "", back, step});
        bus.order("a", {Kind::receive, "", back, step});
        bus.order("a", {Kind::solve, "", -1, step});
      }
      bus.order("a", {Kind::task, "stop", -1, step});
    });
    if (bus.participant("a").tasks.size() < 3) {
      std::printf("%8d %12.0f\n", sizes[s], by_bus);
      continue;
    }
    const double bare = median(bus, [&] {
      for (const std::string name : {"a", "b"})
        bus.order(name, {Kind::task, "bare", -1, step});
    });
    std::printf("%8d %12.0f %16.0f %8.2f\n", sizes[s], by_bus, bare, by_bus / bare);
  }
  const double empty = median(bus, [&] {
    for (const std::string task : {"start", "stop"})
      bus.order("a", {Kind::task, task, -1, {}});
  });
  std::printf("an order executed: %.1f us\n", empty * n_trips);
}

} // namespace

int main(int argc, char **argv) {
  if (argc == 1) {
    bus::Coordinator bus;
    return bus.run([&] { measure(bus); });
  }
  bus::Participant participant(argc, argv, "a", "benchmark_bus");
  return participant.run([&] {
    Dummy dummy(participant);
    participant.serve(dummy);
  });
}
