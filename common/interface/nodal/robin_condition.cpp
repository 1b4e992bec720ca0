#include "common/interface/nodal/robin_condition.h"

#include "common/fem/constraints.h"

#include <cmath>
#include <numeric>
#include <utility>

namespace heartbus::interface {

using fem::Vector;

namespace {

/// Of the values that this rank owns.
double owned_dot(const Vector &x, const Vector &y) {
  return std::inner_product(x.begin(), x.begin() + x.locally_owned_size(), y.begin(), 0.);
}

} // namespace

RobinCondition::RobinCondition(const fem::LagrangeSpace &space, double alpha)
    : alpha(alpha), datum_(space.make_vector(4)), jump_(datum_), jump_n_(datum_) {}

void RobinCondition::set_datum(const Vector &wall_velocity, const Vector &wall_force, const Surface &surface,
                               int iteration, bool accelerated) {
  Vector next(datum_), v = wall_velocity;
  next = 0;
  v.update_ghost_values();
  surface.alpha_mass(v, next);
  next -= wall_force;
  fem::zero_constrained(next, surface.constrained);
  if (iteration == 0)
    anderson_.restart();
  datum_ = accelerated && iteration > 0 ? anderson_.next(datum_, next) : next;
}

void RobinCondition::force(const Vector &u, const Surface &surface, Vector &L) const {
  L = 0;
  surface.alpha_mass(u, L);
  fem::zero_constrained(L, surface.constrained);
  L -= datum_;
}

Budget RobinCondition::budget(const Vector &u, const Vector &wall_velocity, const Vector &L, const Vector &flux,
                              double area, const Surface &surface) {
  Vector change(datum_); // of the datum
  change = 0;
  fem::copy_owned(u, jump_); // off the interface nothing reads it
  jump_ -= wall_velocity;
  jump_.update_ghost_values();
  surface.alpha_mass(jump_, change);
  fem::zero_constrained(change, surface.constrained);
  const double terms[] = {owned_dot(flux, jump_),
                          owned_dot(L, jump_),
                          owned_dot(change, jump_),
                          owned_dot(change, jump_n_),
                          owned_dot(change, change),
                          owned_dot(datum_, datum_),
                          area};
  double sums[7];
  dealii::Utilities::MPI::sum(terms, u.get_mpi_communicator(), sums);
  const auto [defect, power, work, work_n, change_squared, datum_squared, whole_area] = sums;
  jump_power_ = work;
  Budget budget;
  budget.volume_defect = defect;
  budget.power = power;
  budget.kinematic_jump = std::sqrt(alpha * std::abs(work) / whole_area);
  if (datum_squared > 0)
    budget.datum_residual = std::sqrt(change_squared / datum_squared);
  if (work > 0 && jump_power_n_ > 0)
    budget.alternation = work_n / std::sqrt(work * jump_power_n_);
  return budget;
}

void RobinCondition::commit() {
  jump_n_.swap(jump_);
  jump_power_n_ = std::exchange(jump_power_, 0);
}

} // namespace heartbus::interface
