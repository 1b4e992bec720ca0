#include "replay/player.h"

#include <algorithm>
#include <cmath>

namespace heartbus::replay {
namespace {

/// Distance from the first point to the nearest other: only the tolerance of the matching depends on it.
double spacing(const std::vector<double> &coordinates) {
  double smallest = INFINITY;
  for (std::size_t i = 3; i < coordinates.size(); i += 3) {
    const double *p = coordinates.data() + i;
    smallest = std::min(smallest, std::hypot(p[0] - coordinates[0], p[1] - coordinates[1], p[2] - coordinates[2]));
  }
  return smallest;
}

} // namespace

Player::Player(MPI_Comm communicator, const std::string &file_name) : recording_(file_name) {
  int rank, size;
  MPI_Comm_rank(communicator, &rank);
  MPI_Comm_size(communicator, &size);
  const std::size_t n_points = recording_.field().coordinates.size() / 3;
  first_ = n_points * rank / size;
  last_ = n_points * (rank + 1) / size;
}

void Player::declare(bus::Declaration &declaration) {
  const io::RecordedField &field = recording_.field();
  const auto begin = field.coordinates.begin();
  const std::vector<double> mine(begin + 3 * first_, begin + 3 * last_);
  declaration.point_set("recorded", mine, spacing(field.coordinates));
  declaration.output(field.name, "recorded", field.components, field.unit, "n+1", values_);
  values_.assign((last_ - first_) * field.components, 0.);
  declaration.task("inflate", [this](const bus::Step &step) { solve_step(step); }); // in place of the wall's start
}

void Player::solve_step(const bus::Step &step) {
  const std::vector<double> all = recording_.values_at(step.time, step.iteration);
  const unsigned components = recording_.field().components;
  values_.assign(all.begin() + first_ * components, all.begin() + last_ * components);
}

} // namespace heartbus::replay
