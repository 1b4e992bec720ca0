#pragma once

#include "ep_solver/settings/parameters.h"

namespace heartbus::ep {

/// A step of electrophysiology: over so many steps of the coupling, in so many equal substeps. One of the two is 1.
struct Division {
  int steps = 1, substeps = 1;
  double length(double step) const { return steps * step / substeps; } ///< of a substep
};

/// How long the substeps of electrophysiology are: a fixed number in a step of the coupling, or that step times a power
/// of two that an error estimate decides. The estimate is the largest difference of potential and states from their
/// extrapolation with the rates of the substep before, relative to their scales; for a second-order scheme it falls
/// with the square of the substep. What was computed with an estimate above the tolerance is computed again with
/// shorter substeps; after one far below it, the next may have substeps twice as long. Nothing feeds back into
/// electrophysiology: where nothing happens it goes ahead of the coupling, several of its steps at once. Extremes over
/// all nodes decide, so that ranks and partition do not.
class SubstepControl {
 public:
  explicit SubstepControl(const Parameters &parameters);

  /// When substeps should not be longer than `longest`, nor go further than `room`; all in s.
  Division divide(double step, double longest, double room) const;
  /// For another attempt; `division` itself when it was good enough or shorter substeps are not allowed.
  Division refine(double step, Division division, double estimate) const;
  /// Longest substep for the next step [s].
  double longest_next(double substep, double estimate) const;
  /// Whether a cell of this curvature [1/s^2] (cells.h) needs the substeps of a step of this length [s].
  bool is_fast(double curvature, double length) const;
  /// Whether what took a step at once, with this estimate, should have taken its substeps.
  bool is_too_coarse(double estimate) const;

 private:
  int fixed_; ///< 0: by the estimate
  double tolerance_;
};

} // namespace heartbus::ep
