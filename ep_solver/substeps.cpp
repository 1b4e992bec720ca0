#include "ep_solver/substeps.h"

#include <algorithm>
#include <cmath>

namespace heartbus::ep {

namespace {

constexpr double shortest = 5e-6; // [s]: nothing in a cell is faster
constexpr double longest = 8e-4;  // [s]: calcium is right to two thousandths
constexpr double far_below =
    1. / 10; // twice the substep gives four times the estimate; the rest is distance from the limit
constexpr double a_step_away = 1. / 30; // from needing substeps: a smaller share makes more cells fast for nothing,
                                        // with a larger one many steps are computed again
constexpr double round_off = 1e-9;      // of times

} // namespace

SubstepControl::SubstepControl(const Parameters &parameters)
    : fixed_(parameters.automatic_substeps ? 0 : parameters.substeps), tolerance_(parameters.substep_tolerance) {}

Division SubstepControl::divide(double step, double longest_now, double room) const {
  if (fixed_ > 0)
    return {1, fixed_};
  Division division;
  while (division.length(step) > longest_now * (1 + round_off))
    division.substeps *= 2;
  const double reach = std::min({longest_now, longest, room}) * (1 + round_off);
  while (2 * division.length(step) <= reach && division.substeps == 1)
    division.steps *= 2;
  return division;
}

Division SubstepControl::refine(double step, Division division, double estimate) const {
  if (fixed_ > 0)
    return division;
  for (; !(estimate <= tolerance_) && division.length(step) >= 2 * shortest; estimate /= 4)
    if (division.steps > 1)
      division.steps /= 2;
    else
      division.substeps *= 2;
  return division;
}

double SubstepControl::longest_next(double substep, double estimate) const {
  return estimate <= far_below * tolerance_ ? 2 * substep : substep;
}

bool SubstepControl::is_fast(double curvature, double length) const {
  return fixed_ > 0 || !(curvature * length * length <= a_step_away * tolerance_);
}

bool SubstepControl::is_too_coarse(double estimate) const { return fixed_ == 0 && !(estimate <= tolerance_); }

} // namespace heartbus::ep
