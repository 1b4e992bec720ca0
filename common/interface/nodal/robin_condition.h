#pragma once

#include "common/fem/constraints.h"
#include "common/nonlinear/anderson.h"

#include <functional>

namespace heartbus::interface {

/// What the blood's solution leaves of the interface's conditions, with v the wall's new velocity.
struct Budget {
  double volume_defect = 0;  ///< int (u - v).n [m^3/s]
  double power = 0;          ///< L.(u - v) [W]
  double kinematic_jump = 0; ///< alpha |u - v|, root mean square [Pa]
  double datum_residual = 0; ///< |g' - g| / |g| with the last datum g and the next, g' = alpha M v - L
  double alternation = 0; ///< cosine, in M, of the angle between u - v and that of the step before; -1: it alternates
};

/// The Robin condition of the blood, as nodal forces on the wall. With M the mass matrix of the moved interface, v*
/// and W* the wall's velocity and force,
///
///     a_f(u, p; w) + alpha M u = g,    g = alpha M v* - W*,    L = alpha M u - g = W* + alpha M (u - v*).
///
/// Vectors have four components a node, of which the first three count.
class RobinCondition {
 public:
  RobinCondition(const fem::LagrangeSpace &space, double alpha);

  double alpha;
  /// y += alpha M x on this rank's nodes, ghosts of x valid; and the degrees of freedom where the blood is held.
  struct Surface {
    std::function<void(const fem::Vector &x, fem::Vector &y)> alpha_mass;
    const fem::Constraints &constrained;
  };

  /// g, of an iteration of a step. `accelerated`: by Anderson's method from the data of the iterations before.
  void set_datum(const fem::Vector &wall_velocity, const fem::Vector &wall_force, const Surface &surface, int iteration,
                 bool accelerated);
  const fem::Vector &datum() const { return datum_; }
  void force(const fem::Vector &u, const Surface &surface, fem::Vector &L) const;

  /// `flux`.u = int u.n; `area` is this rank's. Collective.
  Budget budget(const fem::Vector &u, const fem::Vector &wall_velocity, const fem::Vector &L, const fem::Vector &flux,
                double area, const Surface &surface);
  void commit();

 private:
  fem::Vector datum_;
  fem::Vector jump_, jump_n_;                // u - v of the last budget, and the one before the last commit
  double jump_power_ = 0, jump_power_n_ = 0; // alpha M (u - v) on itself
  fem::Anderson<fem::Vector> anderson_{10};
};

} // namespace heartbus::interface
