#pragma once

#include "ale_solver/settings/parameters.h"
#include "common/base/stopwatch.h"
#include "common/fem/constraints.h"
#include "common/linear_algebra/block_ilu.h"
#include "common/linear_algebra/linear_solver.h"

#include <memory>

namespace heartbus::ale {

/// Harmonic lifting of the interface's displacement into the fluid domain at rest (paper, eq. (lifting)):
///
///     -Lap d_ALE = 0,   d_ALE = d on the interface,   d_ALE = 0 on `fixed` boundaries,
///
/// and only the normal component zero on `slip` boundaries. The matrix never changes, and the three components share
/// it: they are solved for together.
class LiftingProblem {
 public:
  LiftingProblem(const fem::LagrangeSpace &space, const Parameters &parameters);

  /// Lifts the values that `ale_displacement` (three components a node) has on the interface; all others are
  /// the first guess.
  /// Returns the iterations of all components. Throws Failure(not_finite) naming the cell when det F <= 0 somewhere.
  unsigned lift(fem::Vector &ale_displacement);

  /// For manufactured solutions: whether component i is prescribed at a local node.
  bool prescribed(unsigned node, unsigned i) const { return constrained_[3 * node + i]; }
  double smallest_J() const { return smallest_J_; } ///< of the last lifting, this rank
  bus::Stopwatch stopwatch;

 private:
  void constrain(const Parameters &parameters);
  void assemble(fem::BlockMatrix<double> &matrix) const;
  unsigned solve(fem::Vector &ale_displacement);
  void check(const fem::Vector &ale_displacement);

  const fem::LagrangeSpace &space_;
  double tolerance_;
  fem::Constraints constrained_;                 ///< three components a node
  fem::BlockMatrix<double> laplace_;             ///< without constraints: for residuals
  fem::BlockMatrix<double> matrix_;              ///< with those of nodes that are wholly prescribed
  std::unique_ptr<fem::BlockILU> factorisation_; ///< of that
  double smallest_J_ = 1;
};

} // namespace heartbus::ale
