#include "fsi_solver/fsi_problem.h"

namespace heartbus::fsi {

using fem::Vector;

namespace {

/// How well a linear system of Newton's method is solved at most. Better solutions save few of its iterations: one
/// heartbeat's step takes 8.4, 9.6, 11.2 linear iterations with 1e-2, 1e-3, 1e-4.
constexpr double linear_tolerance = 1e-2;

/// The solid's constraints on the interface, as the fluid numbers its degrees of freedom.
Vector held_by_the_wall(const MergedSpace &space, const fem::Constraints &held) {
  Vector wall = space.solid().make_vector(3), blood = space.fluid().make_vector(4);
  for (unsigned k = 0; k < wall.locally_owned_size(); ++k)
    wall.local_element(k) = held[k];
  space.add_force(wall, blood);
  return blood;
}

} // namespace

FsiProblem::FsiProblem(fluid::NavierStokesProblem &fluid, mech::ElasticityProblem &solid, double dt)
    : fluid_(fluid), solid_(solid), dt_(dt), space_(fluid.space(), solid.space()), interface_blocks_(space_),
      preconditioner_(space_, interface_blocks_, fluid, solid, dt), newton_settings_(solid.newton_settings()),
      x_f_(fluid.space().make_vector(4)), y_f_(x_f_), d_(solid.space().make_vector(3)), y_s_(d_), force_(x_f_) {
  fluid_.hold(held_by_the_wall(space_, solid.constrained()));
}

fem::NewtonStatistics FsiProblem::solve_step(Vector &d) {
  solid_.begin_dynamic(dt_);
  Vector x = space_.make_vector();
  space_.clear_wall(d);
  space_.merge(fluid_.guess(), d, x);
  Vector d_n(d), other_start(x);
  fem::copy_owned(solid_.past[0], d_n);
  space_.clear_wall(d_n);
  space_.merge(fluid_.guess(), d_n, other_start);
  const fem::NewtonStatistics statistics = fem::newton("fluid and structure", *this, x, newton_settings_, &other_start);
  preconditioner_age_.note(statistics.linear_iterations);
  displace(x);
  d = d_;
  fluid_.accept(x_f_, force_);
  return statistics;
}

void FsiProblem::displace(const Vector &x) {
  space_.split(x, x_f_, d_);
  space_.move_wall(x_f_, dt_, d_);
  for (const unsigned node : space_.interface().solid_nodes())
    for (unsigned i = 0; i < 3; ++i)
      d_.local_element(3 * node + i) += solid_.past[0].local_element(3 * node + i);
}

fem::ResidualSize FsiProblem::residual(const Vector &x, Vector &r) {
  displace(x);
  fem::ResidualSize size = solid_.residual(d_, y_s_);
  force_ = 0;
  space_.add_force(y_s_, force_);
  fem::zero_constrained(force_, fluid_.constraints());
  fluid_.residual(x_f_, y_f_);
  y_f_ += force_;
  space_.clear_wall(y_s_);
  space_.merge(y_f_, y_s_, r);
  size.norm = r.l2_norm();
  wanted_residual_ = newton_settings_.residual_tolerance * size.scale;
  return size;
}

void FsiProblem::linearise(const Vector &x) {
  displace(x);
  solid_.linearise(d_);
}

/// The merged matrix times x: the wall moves with the blood, and its forces on the interface count as the blood's.
void FsiProblem::apply(Vector &y, const Vector &x) {
  space_.split(x, x_f_, d_);
  space_.move_wall(x_f_, dt_, d_);
  fluid_.apply(y_f_, x_f_);
  solid_.apply_tangent(y_s_, d_);
  space_.add_force(y_s_, y_f_);
  fem::zero_constrained(y_f_, fluid_.constraints());
  space_.clear_wall(y_s_);
  space_.merge(y_f_, y_s_, y);
}

void FsiProblem::refresh_preconditioner() {
  if (!preconditioner_age_.is_due() && open_orifices_ == fluid_.open_orifices())
    return;
  const bus::Stopwatch::Section section(stopwatch, "preconditioner");
  preconditioner_.make();
  open_orifices_ = fluid_.open_orifices();
  preconditioner_age_.renew();
}

unsigned FsiProblem::solve(Vector &dx, const Vector &r) {
  refresh_preconditioner();
  Vector b(r);
  b *= -1;
  // Beyond what Newton's method wants, the linear residual does not matter.
  const double tolerance = std::max(linear_tolerance, 0.1 * wanted_residual_ / b.l2_norm());
  try {
    const bus::Stopwatch::Section section(stopwatch, "linear solve");
    return fem::solve_linear(
               "fluid and structure", [this](Vector &y, const Vector &x) { apply(y, x); }, dx, b, preconditioner_,
               tolerance, solid_.tangent_solver().most_iterations())
        .iterations;
  } catch (const Failure &failure) {
    if (failure.code() != ExitCode::not_converged || !solid_.tangent_solver().strengthen())
      throw;
  }
  preconditioner_age_.forget();
  dx = 0;
  return solve(dx, r);
}

double FsiProblem::size(const Vector &dx) {
  space_.split(dx, x_f_, d_);
  space_.move_wall(x_f_, dt_, d_);
  return d_.linfty_norm();
}

} // namespace heartbus::fsi
