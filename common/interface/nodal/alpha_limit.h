#pragma once

#include "common/fem/constraints.h"

namespace heartbus::interface {

/// The wall as the interface sees it in small motions about its present state d^n. With M, C and K its mass, damping
/// and stiffness, A(tau) = M/tau^2 + C/tau + K.
class LinearWall {
 public:
  virtual ~LinearWall() = default;
  virtual const fem::LagrangeSpace &space() const = 0;
  virtual const fem::Constraints &constrained() const = 0; ///< degrees of freedom, three a node
  virtual void linearise(double tau, double time) = 0;     ///< A(tau), under the loads of that time [s]
  /// A^{-1} f
  virtual fem::Vector answer(const fem::Vector &force) = 0;
  /// M_S x with the mass matrix of the moved interface, free degrees of freedom only.
  virtual fem::Vector interface_mass(const fem::Vector &x) const = 0;
};

/// How large alpha may be. A coupling that fails does so by a force L on the interface that changes its sign each time:
/// from step to step where blood and wall are solved once a step, from iteration to iteration where these are repeated.
/// The wall answers with the velocity v = Z^{-1} L, the blood yields with u = -F^{-1} L, and the blood's Robin
/// condition ties them by
///
///     2 L = alpha M_S (u + v),    hence    alpha_limit = 2 / lambda_max((Z^{-1} - F^{-1}) M_S),
///
/// with M_S the mass matrix of the moved interface. Within a step of size dt Z^{-1} = A(dt)^{-1}/dt; alternating from
/// step to step, differences in time make the wall 4 M/dt^2 + 2 C/dt + K = A(dt/2). Of the uniform motion in a closed
/// cavity, which cannot yield, this is alpha = 2 Z (limit of a heavy fluid in the model problem of Causin, Gerbeau and
/// Nobile 2005, doi:10.1016/j.cma.2004.12.005). Arnoldi's method finds lambda from a few forces and the answers to
/// them; orthogonality is that of M_S, for which the operator is all but symmetric.
class AlphaLimit {
 public:
  explicit AlphaLimit(LinearWall &wall) : wall_(wall) {}
  /// A new estimate with A(tau), which stays the wall's, under the loads of that time [s].
  void begin(double tau, double time);
  /// To be answered by the blood.
  const fem::Vector &force() const { return forces_.back(); }
  /// With the blood's velocity under `force`: one step, which has the next force.
  void add(const fem::Vector &blood_velocity);
  /// From all answers so far [kg/(m^2 s)].
  double value() const;

 private:
  /// Z^{-1} f
  fem::Vector compliance(const fem::Vector &f);
  fem::Vector some_displacement() const;
  void take(const fem::Vector &x, const fem::Vector &Mx, double norm);

  LinearWall &wall_;
  double tau_ = 0;
  bool exhausted_ = false;                    ///< there are no more directions
  std::vector<fem::Vector> motions_, forces_; ///< x_i, orthonormal in M_S, and M_S x_i
  std::vector<std::vector<double>> columns_;  ///< of the Hessenberg matrix
};

} // namespace heartbus::interface
