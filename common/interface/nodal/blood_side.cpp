#include "common/interface/nodal/blood_side.h"

#include "common/base/failure.h"
#include "common/interface/alpha.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace heartbus::interface {

BloodSide::BloodSide(const fem::LagrangeSpace &space, const BloodSettings &settings, double dt)
    : settings(settings), nodes_(space, 4), watch_(dt) {
  wall_velocity_ = wall_force_ = blood_force_ = held_ = nodes_.values();
  if (!is_robin())
    return;
  wall_velocity_ = wall_force_ = nodes_.values(std::numeric_limits<double>::quiet_NaN()); // until they come
  probe_force_ = probe_velocity_ = blood_velocity_ = unit_pressure_force_ = nodes_.values();
  alpha_limit_.resize(nodes_.size());
  pressure_correction_ = alpha_limit_;
  seen_.iterates = settings.alternation == Alternation::iterations;
}

void BloodSide::declare_data(bus::Declaration &bus) {
  bus.input("held", "interface", 3, "1", held_);
  if (settings.condition != BloodSettings::Condition::motion) {
    bus.input("wall_velocity", "interface", 3, "m/s", wall_velocity_);
    bus.input("wall_force", "interface", 3, "N", wall_force_);
  }
  bus.output("blood_force", "interface", 3, "N", "n+1", blood_force_);
}

void BloodSide::declare_more(bus::Declaration &bus) {
  bus.input("alpha_limit", "interface", 1, "kg/(m^2 s)", alpha_limit_, "follow_limit");
  bus.input("probe_force", "interface", 3, "N", probe_force_, "probe");
  bus.output("probe_velocity", "interface", 3, "m/s", "n", probe_velocity_);
  bus.output("blood_velocity", "interface", 3, "m/s", "n+1", blood_velocity_);
  bus.output("unit_pressure_force", "interface", 3, "m^2", "n+1", unit_pressure_force_);
  bus.input("pressure_correction", "interface", 1, "Pa", pressure_correction_, "correct");
}

void BloodSide::give_for_correction(const fem::Vector &u, const fem::Vector &unit_pressure_force) {
  nodes_.get(u, blood_velocity_);
  nodes_.get(unit_pressure_force, unit_pressure_force_);
}

/// Blood without its datum would be left to itself, at no pressure.
void BloodSide::require_wall() {
  if (!is_robin() || has_wall_)
    return;
  const auto is_missing = [](const std::vector<double> &datum) {
    return std::any_of(datum.begin(), datum.end(), [](double value) { return std::isnan(value); });
  };
  const int missing = is_missing(wall_velocity_) || is_missing(wall_force_);
  if (dealii::Utilities::MPI::max(missing, nodes_.space().communicator()))
    throw Failure(ExitCode::scene, "the blood needs 'wall_velocity' and 'wall_force' on the interface, which nobody "
                                   "sends: let 'mech' take part, or choose a scheme in which the blood follows a "
                                   "prescribed motion (docs/schemes.md)");
  has_wall_ = true;
}

double BloodSide::followed_alpha() {
  seen_.automatic_alpha = true;
  return share_of_limit * uniform(alpha_limit_);
}

double BloodSide::uniform(const std::vector<double> &values) const {
  const double value = values.empty() ? std::numeric_limits<double>::lowest() : values[0];
  return dealii::Utilities::MPI::max(value, nodes_.space().communicator());
}

bool BloodSide::runs_away(const Budget &budget, double alpha) {
  seen_.kinematic_jump = budget.kinematic_jump;
  seen_.alpha = alpha;
  seen_.alpha_limit = uniform(alpha_limit_);
  const bool is_dirichlet = seen_.alpha_limit > 0 && alpha > 10 * seen_.alpha_limit;
  const bool runs = watch_.add(budget.kinematic_jump, budget.datum_residual, is_dirichlet, budget.alternation);
  seen_.alternates = watch_.alternates();
  return runs;
}

} // namespace heartbus::interface
