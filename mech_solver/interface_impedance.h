#pragma once

#include "mech_solver/elasticity_problem.h"

namespace heartbus::mech {

/// How large alpha may be. A coupling that fails does so by a force L on the interface that changes its sign each time:
/// from step to step in the loosely coupled scheme, from iteration to iteration where these are repeated. The wall
/// answers with the velocity v = Z^{-1} L, the blood yields with u = -F^{-1} L, and the fluid's Robin condition ties
/// them by
///
///     2 L = alpha M_S (u + v),   hence   alpha_limit = 2 / lambda,  lambda the largest eigenvalue of (Z^{-1} - F^{-1})
///     M_S
///
/// with M_S the mass matrix of the moved interface. Within a step of size dt the wall is A(dt) = M/dt^2 + C/dt + K,
/// thus Z^{-1} = A(dt)^{-1}/dt; alternating from step to step, differences in time make it 4 M/dt^2 + 2 C/dt + K =
/// A(dt/2). Of the uniform motion in a closed cavity, which cannot yield, this is alpha = 2 Z (limit of a heavy fluid
/// in the model problem of Causin, Gerbeau and Nobile 2005, doi:10.1016/j.cma.2004.12.005). Arnoldi's method finds
/// lambda from a few forces and the answers to them; orthogonality is that of M_S, for which the operator is all but
/// symmetric.
class InterfaceImpedance {
 public:
  explicit InterfaceImpedance(ElasticityProblem &problem);
  /// A new estimate at the state d^n, with A(dt); leaves the tangent of that dt behind.
  void begin(double dt);
  /// To be answered by the blood.
  const fem::Vector &force() const { return forces_.back(); }
  /// With the blood's velocity under `force`: one step, which has the next force.
  void add(const fem::Vector &blood_velocity);
  /// From all answers so far.
  double alpha_limit() const;

 private:
  /// Z^{-1} f
  fem::Vector compliance(const fem::Vector &f);
  /// M_S x, free degrees of freedom only.
  fem::Vector mass(const fem::Vector &x) const;
  fem::Vector some_motion() const;
  void take(const fem::Vector &x, const fem::Vector &Mx, double norm);

  ElasticityProblem &problem_;
  LoadedSurface surface_;
  double dt_ = 0;
  bool exhausted_ = false;                    ///< there are no more directions
  std::vector<fem::Vector> motions_, forces_; ///< x_i, orthonormal in M_S, and M_S x_i
  std::vector<std::vector<double>> columns_;  ///< of the Hessenberg matrix
};

} // namespace heartbus::mech
