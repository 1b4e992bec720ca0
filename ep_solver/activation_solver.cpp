#include "ep_solver/activation_solver.h"

#include "common/fem/owned_points.h"

#include <cmath>

namespace heartbus::ep {

ActivationSolver::ActivationSolver(const fem::LagrangeSpace &space, std::vector<double> activation,
                                   const IonicModel &model, const Parameters &parameters)
    : space_(space), period_(parameters.stimulus.period), transient_(model, parameters.initial_state, period_),
      prescribed_(parameters.prescribed), activation_(std::move(activation)), calcium_(space.n_owned_nodes()),
      output_(space) {
  set_calcium(0);
}

void ActivationSolver::declare(bus::Declaration &declaration) {
  declaration.point_set("tissue", fem::owned_points(space_), space_.smallest_cell_size());
  declaration.output("calcium", "tissue", 1, "uM", "n+1", calcium_);
  declare_activation(declaration, space_, activation_, now_);
}

double ActivationSolver::calcium_at(double phase) const {
  if (!prescribed_.has_calcium())
    return transient_.calcium(phase);
  return prescribed_.calcium.at(std::isnan(phase) ? 0 : phase - period_ * std::floor(phase / period_));
}

void ActivationSolver::set_calcium(double time) {
  for (std::size_t node = 0; node < calcium_.size(); ++node)
    calcium_[node] = calcium_at(time - activation_[node]);
}

void ActivationSolver::prepare_step(const bus::Step &step) {
  if (output_.writes_start(step))
    write(0);
}

void ActivationSolver::solve_step(const bus::Step &step) { set_calcium(step.time); }

void ActivationSolver::commit_step(const bus::Step &step) {
  now_ = step.time - period_ * std::floor(step.time / period_ - 1e-9);
  if (output_.is_due(step))
    write(step.time);
}

void ActivationSolver::load_state(const std::string &, const bus::Step &step) {
  output_.go_on_from(step.time);
  set_calcium(step.time);
  now_ = step.time - period_ * std::floor(step.time / period_ - 1e-9);
}

void ActivationSolver::write(double time) {
  std::vector<double> potential;
  for (const double activation : activation_)
    potential.push_back(transient_.potential(time - activation));
  output_.write(time, potential.data(), calcium_.data());
}

void ActivationSolver::finish() {
  std::vector<double> repolarisation;
  for (const double activation : activation_)
    repolarisation.push_back(activation + transient_.repolarisation());
  output_.write_maps(activation_.data(), repolarisation.data());
}

} // namespace heartbus::ep
