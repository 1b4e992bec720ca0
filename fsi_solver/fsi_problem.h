#pragma once

#include "fsi_solver/fsi_preconditioner.h"

namespace heartbus::fsi {

/// The monolithic step (paper, eq. (fsi-implicit)): blood and wall at once on the geometry of d^n.
/// With the fluid's form a_f, linear in a step, and the solid's residual R_s, both as forces on nodes, find u, p, d
/// with
///
///     u = (d - d^n)/dt on the interface,     a_f(u, p; w, q) + R_s(d; w) = 0
///
/// where a test function of the interface serves both. So the interface displacement is no unknown: d = d^n + dt u. The
/// sum is solved by Newton's method (fem::newton sees this class as residual, linearise, solve and size), its linear
/// systems by GMRES on the two matrices as they are; tangent and preconditioner are kept from step to step until they
/// show their age, as where the two are apart.
class FsiProblem {
 public:
  /// `fluid` is meant to have alpha = 0. What either side holds on the interface, both hold.
  FsiProblem(fluid::NavierStokesProblem &fluid, mech::ElasticityProblem &solid, double dt);

  /// Solves the step for which `fluid` has been prepared and `solid` holds old states and tension. `d`: the new
  /// displacement, on entry a guess; velocity and pressure go to `fluid`.
  fem::NewtonStatistics solve_step(fem::Vector &d);
  /// The blood's force on the wall, on the fluid's nodes: what the wall's residual asks for.
  const fem::Vector &blood_force() const { return force_; }
  const MergedSpace &space() const { return space_; }
  bus::Stopwatch stopwatch; ///< of what neither side times itself
  /// The next solve makes it anew.
  void forget_preconditioner() { preconditioner_age_.forget(); }

  // Newton's view
  fem::ResidualSize residual(const fem::Vector &x, fem::Vector &r);
  bool has_tangent() const { return solid_.has_tangent(); }
  void linearise(const fem::Vector &x);
  unsigned solve(fem::Vector &dx, const fem::Vector &r);
  double size(const fem::Vector &dx);
  void refuse() const { solid_.refuse(); }

 private:
  void displace(const fem::Vector &x); ///< d_ from the unknowns
  void apply(fem::Vector &y, const fem::Vector &x);
  void refresh_preconditioner();

  fluid::NavierStokesProblem &fluid_;
  mech::ElasticityProblem &solid_;
  double dt_;
  MergedSpace space_;
  InterfaceBlocks interface_blocks_;
  FsiPreconditioner preconditioner_;
  fem::NewtonSettings newton_settings_;
  std::vector<bool> open_orifices_;              ///< for which the preconditioner was made
  fem::PreconditionerAge preconditioner_age_{3}; ///< by the iterations of a step
  double wanted_residual_ = 0;                   ///< of Newton's method, at the last state looked at
  fem::Vector x_f_, y_f_, d_, y_s_, force_;
};

} // namespace heartbus::fsi
