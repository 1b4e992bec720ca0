#pragma once

#include "ale_solver/parameters.h"
#include "common/bus/stopwatch.h"
#include "common/fem/constraints.h"
#include "common/fem/linear_solver.h"
#include "common/fem/nodal_matrix.h"

#include <array>
#include <memory>
#include <vector>

namespace heartbus::ale {

/// Harmonic lifting of the interface's displacement into the fluid domain at rest (paper, eq. (lifting)):
///
///     -Lap d_ALE = 0,   d_ALE = d on the interface,   d_ALE = 0 on `fixed` boundaries,
///
/// and only the normal component zero on `slip` boundaries. The matrix never changes; the three components share it
/// where they have the same prescribed nodes.
class LiftingProblem {
 public:
  LiftingProblem(const fem::LagrangeSpace &space, const Parameters &parameters);

  /// Lifts the values that `motion` (three components a node) has on the interface; all others are the first guess.
  /// Returns the iterations of all components. Throws Failure(not_finite) naming the cell when det F <= 0 somewhere.
  unsigned lift(fem::Vector &motion);

  /// For manufactured solutions: whether component i is prescribed at a local node.
  bool prescribed(unsigned node, unsigned i) const { return systems_[of_component_[i]].constrained[node]; }
  double smallest_J() const { return smallest_J_; } ///< of the last lifting, this rank
  bus::Stopwatch stopwatch;

 private:
  /// What components with the same prescribed nodes share.
  struct System {
    fem::Constraints constrained;
    std::unique_ptr<fem::NodalMatrix> matrix;
    std::unique_ptr<fem::Preconditioner> preconditioner;
  };
  std::array<fem::Constraints, 3> constraints(const Parameters &parameters) const;
  void assemble(fem::NodalMatrix &matrix) const;
  unsigned lift_component(fem::Vector &motion, unsigned i);
  void check(const fem::Vector &motion);

  const fem::LagrangeSpace &space_;
  double tolerance_;
  fem::NodalMatrix laplace_; ///< without constraints: for residuals
  std::vector<System> systems_;
  std::array<unsigned, 3> of_component_{};
  double smallest_J_ = 1;
};

} // namespace heartbus::ale
