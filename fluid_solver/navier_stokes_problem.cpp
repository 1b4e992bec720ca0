#include "fluid_solver/navier_stokes_problem.h"

#include "common/base/failure.h"
#include "common/linear_algebra/block_ilu.h"
#include "fluid_solver/block_preconditioner.h"

#include <cmath>
#include <numeric>
#include <utility>

namespace heartbus::fluid {

using fem::n_lanes;
using fem::Vector;
using fem::VectorizedDouble;

namespace {

/// Nodes of the unit cell of stabilization.h in the finite element's order.
std::vector<double> unit_cell_nodes(unsigned nodes_per_cell) {
  if (nodes_per_cell == 4) {
    const double x = 1 / std::sqrt(2.); // every second corner of a cube
    return {x, x, x, x, -x, -x, -x, x, -x, -x, -x, x};
  }
  if (nodes_per_cell != 8)
    throw Failure(ExitCode::scene, "the fluid needs elements of degree 1");
  std::vector<double> nodes;
  for (unsigned a = 0; a < 8; ++a)
    for (unsigned i = 0; i < 3; ++i)
      nodes.push_back((a >> i) & 1 ? 1 : -1);
  return nodes;
}

} // namespace

NavierStokesProblem::NavierStokesProblem(const fem::LagrangeSpace &space, const Parameters &parameters, double alpha,
                                         double dt)
    : boundary_values(space.make_vector(4)), space_(space), parameters_(parameters), dt_(dt), robin_(space, alpha),
      unit_nodes_(unit_cell_nodes(space.nodes_per_cell())), A_(space, 4), past_(3, space.make_vector(4)), x_(past_[0]),
      d_n_(space.make_vector(3)), d_np1_(d_n_), guess_(x_), increment_(x_), residual_(x_), guess_load_(x_), force_(x_) {
  const double h = space.smallest_cell_size();
  pressure_scale_ = parameters.density * h / dt + parameters.viscosity / h;
  if (space.has_label("interface"))
    interface_.emplace(space, "interface");
}

Orifice &NavierStokesProblem::add_orifice(const std::string &label, double pressure, double resistance) {
  orifices_.push_back(std::make_unique<Orifice>(space_, label, pressure, resistance));
  return *orifices_.back();
}

void NavierStokesProblem::start(const Vector &ale_displacement) {
  d_n_ = ale_displacement;
  past_[0] = 0;
  for (unsigned node = 0; node < space_.n_owned_nodes(); ++node)
    past_[0].local_element(4 * node + 3) = parameters_.initial_pressure / pressure_scale_;
  past_.forget();
  resume();
  history_is_new_ = true;
}

void NavierStokesProblem::resume() {
  history_is_new_ = false;
  d_n_.update_ghost_values();
  d_np1_ = d_n_;
  d_np1_.update_ghost_values();
  past_[0].update_ghost_values();
  x_ = past_[0];
  x_.update_ghost_values();
  update_averages();
}

void NavierStokesProblem::visit(io::State &state) {
  update_constraints(); // those of now, so that a valve that switches next is seen to do so
  state.field("ale_displacement", 3, d_n_.begin());
  state.field("velocity_and_pressure", 4, past_[0].begin());
  state.field("velocity_and_pressure_nm1", 4, past_[1].begin());
  state.field("velocity_and_pressure_nm2", 4, past_[2].begin());
  double scale = pressure_scale_; // kept with the scaled values: dividing and multiplying would cost a bit
  state.number("pressure_scale", scale);
  for (unsigned node = 0; node < space_.n_owned_nodes() && scale != pressure_scale_; ++node)
    for (unsigned age = 0; age < 3; ++age)
      past_[age].local_element(4 * node + 3) *= scale / pressure_scale_;
}

void NavierStokesProblem::forget_preconditioner() {
  preconditioner_age_.forget();
  iterate_extrapolation_.forget();
}

void NavierStokesProblem::follow_motion() {
  follows_motion_ = true;
  robin_.alpha = 0;
  constraints_are_known_ = false;
}

/// Of the mesh, from d^n to d^{n+1}; zero off the interface.
void NavierStokesProblem::set_interface_velocity() {
  const auto on = space_.nodes_on("interface");
  for (unsigned k = 0; k < 3 * space_.n_owned_nodes(); ++k)
    if (on[k / 3])
      boundary_values.local_element(4 * (k / 3) + k % 3) = (d_np1_.local_element(k) - d_n_.local_element(k)) / dt_;
}

void NavierStokesProblem::move(const Vector &ale_displacement) {
  fem::copy_owned(ale_displacement, d_np1_);
  d_np1_.update_ghost_values();
  if (interface_)
    interface_->move(d_np1_);
}

double NavierStokesProblem::volume_rate(const Vector &ale_displacement) {
  move(ale_displacement);
  set_interface_velocity();
  return interface_->flux_functional() * boundary_values;
}

void NavierStokesProblem::prepare(const Vector &ale_displacement) {
  move(ale_displacement);
  if (follows_motion_)
    set_interface_velocity();
  update_constraints();
  set_guess();
  assemble();
  A_.vmult(guess_load_, guess_);
}

void NavierStokesProblem::hold(const Vector &held) {
  const fem::GhostValues ghosts(held);
  held_by_the_wall_.resize(4 * space_.n_local_nodes());
  for (std::size_t k = 0; k < held_by_the_wall_.size(); ++k)
    held_by_the_wall_[k] = held.begin()[k] != 0;
  constraints_are_known_ = false; // to be made anew
}

void NavierStokesProblem::update_constraints() {
  std::vector<bool> open;
  for (const auto &orifice : orifices_)
    open.push_back(orifice->open);
  if (constraints_are_known_ && open == orifices_open_)
    return;
  constraints_are_known_ = true;
  orifices_open_ = open;
  constrained_ = held_by_the_wall_;
  constrained_.resize(4 * space_.n_local_nodes(), 0);
  for (const auto &label : parameters_.no_slip)
    fem::fix_vector(space_, 4, label, constrained_);
  for (const auto &label : parameters_.slip)
    fem::fix_normal(space_, 4, label, constrained_);
  if (follows_motion_)
    fem::fix_vector(space_, 4, "interface", constrained_);
  for (const auto &orifice : orifices_)
    if (!orifice->open)
      fem::fix_vector(space_, 4, orifice->label, constrained_);
  A_.set_constraints(constrained_);
  preconditioner_age_.forget();
  past_.forget(); // no extrapolation over the switch of a valve
  iterate_extrapolation_.forget();
  history_is_new_ = true;
}

/// The parabola through the last three states: half as many iterations as from the line through two.
void NavierStokesProblem::set_guess() {
  past_.extrapolate(guess_);
  for (unsigned k = 0; k < guess_.locally_owned_size(); ++k)
    if (constrained_[k])
      guess_.local_element(k) = boundary_values.local_element(k);
  guess_.update_ghost_values();
}

void NavierStokesProblem::refresh_preconditioner() {
  if (!preconditioner_age_.is_due())
    return;
  const bus::Stopwatch::Section section(stopwatch, "preconditioner");
  if (parameters_.preconditioner == "ilu")
    preconditioner_ = std::make_unique<fem::BlockILU>(A_);
  else
    preconditioner_ = make_preconditioner(fem::BlockMatrix<double>(A_));
  preconditioner_age_.renew();
}

std::unique_ptr<fem::Preconditioner>
NavierStokesProblem::make_preconditioner(const fem::BlockMatrix<double> &matrix) const {
  if (parameters_.preconditioner == "simplec")
    return std::make_unique<Simplec>(matrix);
  return fem::make_preconditioner("ilu", matrix);
}

/// y = (A + sum R c c^T) x: the resistances couple all nodes of an orifice, hence are kept out of the matrix.
void NavierStokesProblem::apply(Vector &y, const Vector &x) const {
  A_.vmult(y, x);
  for (const auto &orifice : orifices_)
    if (orifice->open && orifice->resistance > 0)
      y.add(orifice->resistance * (orifice->flux * x), orifice->flux);
}

void NavierStokesProblem::residual(const Vector &x, Vector &r) const {
  Vector change = x;
  change -= guess_;
  apply(r, change);
  r += residual_;
}

fem::LinearStatistics NavierStokesProblem::solve(const Vector &wall_velocity, const Vector &wall_force, int iteration) {
  if (interface_ && !std::exchange(has_datum_, false))
    robin_.set_datum(wall_velocity, wall_force, robin_surface(), iteration, false);
  Vector b = robin_.datum();
  b -= residual_;
  Vector loads = b;
  loads += guess_load_;
  const auto [norm, norm_of_loads] = fem::norms(b, loads);
  const double tolerance = parameters_.tolerance * std::max(1., norm_of_loads / norm);

  if (iteration == 0) {
    refresh_preconditioner();
    increment_ = 0;
  }
  fem::LinearStatistics statistics;
  if (norm == 0 || tolerance >= 1)
    increment_ = 0; // the guess is good enough
  else {
    const bus::Stopwatch::Section section(stopwatch, "linear solve");
    iterate_extrapolation_.predict(iteration, increment_);
    statistics = fem::solve_linear(
        "Navier-Stokes", [this](Vector &y, const Vector &x) { apply(y, x); }, increment_, b, *preconditioner_,
        tolerance);
  }
  preconditioner_age_.note(statistics.iterations);
  iterate_extrapolation_.record(iteration, increment_);

  fem::copy_owned(guess_, x_);
  x_ += increment_;
  x_.update_ghost_values();
  if (interface_)
    robin_.force(x_, robin_surface(), force_);
  if (follows_motion_)
    set_reaction_force();
  return statistics;
}

void NavierStokesProblem::accelerate(const Vector &wall_velocity, const Vector &wall_force, int iteration) {
  if (!interface_)
    return;
  robin_.set_datum(wall_velocity, wall_force, robin_surface(), iteration, true);
  has_datum_ = true;
}

interface::RobinCondition::Surface NavierStokesProblem::robin_surface() const {
  return {[this](const Vector &x, Vector &y) { interface_->apply_mass(interface_masses_, x, y); }, constrained_};
}

void NavierStokesProblem::accept(const Vector &x, const Vector &blood_force) {
  fem::copy_owned(x, x_);
  x_.update_ghost_values();
  force_ = blood_force;
}

void NavierStokesProblem::commit() {
  robin_.commit();
  past_.push(x_);
  if (std::exchange(history_is_new_, false)) // two states only: the parabola becomes the line through them
    past_.straighten();
  past_[0].update_ghost_values();
  fem::copy_owned(d_np1_, d_n_);
  d_n_.update_ghost_values();
  iterate_extrapolation_.commit();
  update_averages();
}

void NavierStokesProblem::add_pressure(double pressure) {
  for (unsigned node = 0; node < space_.n_owned_nodes(); ++node)
    increment_.local_element(4 * node + 3) += pressure / pressure_scale_;
  iterate_extrapolation_.record(1, increment_); // the next step starts from what will be before this
  fem::copy_owned(guess_, x_);
  x_ += increment_;
  x_.update_ghost_values();
  force_.add(pressure, unit_pressure_force());
}

Vector NavierStokesProblem::unit_pressure_force() const {
  Vector b = interface_flux_;
  fem::zero_constrained(b, constrained_);
  return b;
}

interface::Budget NavierStokesProblem::budget(const Vector &wall_velocity) {
  if (!interface_)
    return {};
  return robin_.budget(x_, wall_velocity, force_, interface_flux_, interface_area_, robin_surface());
}

Inflow NavierStokesProblem::inflow(const Orifice &orifice) const { return orifice.inflow(x_, parameters_.density); }

} // namespace heartbus::fluid
