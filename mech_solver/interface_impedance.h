#pragma once

#include "mech_solver/elasticity_problem.h"

namespace heartbus::mech {

/// How the wall resists motion of its interface within one time step, as seen from the blood. With the step's operator
/// A(dt) = M/dt^2 + C/dt + K, the nodal force b of a unit pressure and the mass matrix M_S of the moved interface S,
///
///     Z(dt) = dt |S| / (b . A^{-1} b)      resists a uniform pressure: traction per velocity [kg/(m^2 s)],
///     Z_min(dt) = dt / mu,  mu the largest eigenvalue of  A^{-1} M_S,      resists the most compliant motion.
///
/// Robin-Neumann iterations in a closed cavity multiply the error of a motion by 1 - alpha/Z(dt): they diverge for some
/// motion beyond alpha = 2 Z_min(dt). The loosely coupled scheme takes one iteration a step and fails by an alternating
/// motion, for which differences in time make 4 M/dt^2 + 2 C/dt + K = A(dt/2) of A(dt): beyond alpha = 2 Z(dt/2) for
/// uniform motion, 2 Z_min(dt/2) for any (limit of a heavy fluid in the model problem of Causin, Gerbeau and Nobile 2005,
/// doi:10.1016/j.cma.2004.12.005; blood that moves along makes both milder).
class InterfaceImpedance {
 public:
  explicit InterfaceImpedance(ElasticityProblem &problem);
  /// Both are of the state d^n and leave the tangent of that dt behind.
  double uniform(double dt);
  double smallest(double dt);

 private:
  /// A w = f.
  fem::Vector compliance(const fem::Vector &f);
  /// M_S x, free degrees of freedom only.
  fem::Vector mass(const fem::Vector &x) const;
  fem::Vector some_motion() const;

  ElasticityProblem &problem_;
  FollowerPressure surface_;
};

} // namespace heartbus::mech
