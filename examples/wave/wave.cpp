// A wave of calcium through the wall, in place of electrophysiology.
#include <algorithm>
#include <cmath>
#include <heartbus/heartbus.hpp>
#include <mpi.h>

constexpr double rest = 0.13, rise = 0.025, decay = 0.15; // uM, s, s

class Wave : public heartbus::Solver {
 public:
  explicit Wave(heartbus::Bus &bus)
      : velocity(bus.setting("velocity", "m/s", 0.6)), peak(bus.setting("peak", "uM", 0.8)) {
    const auto wall = bus.partner("mech", "tissue");
    int rank, size;
    MPI_Comm_rank(MPI_Comm_f2c(bus.communicator()), &rank);
    MPI_Comm_size(MPI_Comm_f2c(bus.communicator()), &size);
    const long first = long(wall.n_points) * rank / size, last = long(wall.n_points) * (rank + 1) / size;
    mine.assign(wall.points + 3 * first, wall.points + 3 * last);
    for (int i = 0; i < wall.n_points; ++i)
      apex = std::min(apex, wall.points[3 * i + 2]);
    bus.points("tissue", mine, wall.spacing);
    calcium = bus.output("calcium", "tissue", 1, "uM");
    highest = &bus.scalar("highest_calcium", "uM", HEARTBUS_MAX);
  }
  void solve(const heartbus::Order &order) override {
    for (std::size_t i = 0; i < calcium.size; ++i) {
      const double activation = (mine[3 * i + 2] - apex) / velocity; // from the apex upwards
      const double t = std::max(order.time - activation, 0.);
      calcium[i] = rest + (peak - rest) * (1 - std::exp(-t / rise)) * std::exp(-t / decay);
    }
    *highest = calcium.size > 0 ? *std::max_element(calcium.begin(), calcium.end()) : 0;
  }
  void load(const heartbus::Order &order) override { solve(order); } // all state is the time

 private:
  const double velocity, peak;
  double apex = INFINITY, *highest = nullptr;
  std::vector<double> mine;
  heartbus::Values calcium;
};

int main() {
  return heartbus::participate("ep", "wave", [](heartbus::Bus &bus) {
    Wave wave(bus);
    heartbus::serve(bus, wave);
  });
}
