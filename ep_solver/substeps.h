#pragma once

#include "ep_solver/parameters.h"

namespace heartbus::ep {

/// Into how many equal substeps a step of the coupling is divided: a fixed number, or a power of two that an error
/// estimate decides. The estimate is the largest difference of potential and states from their extrapolation with the
/// rates of the substep before, relative to their scales; for a second-order scheme it falls with the square of the
/// substep. A step of the coupling whose estimate is above the tolerance is computed again with shorter substeps; after
/// one far below it, the next may have substeps twice as long. Extremes over all nodes decide, so that ranks and
/// partition do not.
class SubstepControl {
 public:
  explicit SubstepControl(const Parameters &parameters);

  /// Substeps for a step of the coupling [s] when they should not be longer than `longest` [s].
  int divide(double step, double longest) const;
  /// Substeps for another attempt; `n` when the step was good enough or shorter substeps are not allowed.
  int refine(double step, int n, double estimate) const;
  /// Longest substep for the next step of the coupling [s].
  double longest_next(double substep, double estimate) const;

 private:
  int fixed_; ///< 0: by the estimate
  double tolerance_;
};

} // namespace heartbus::ep
