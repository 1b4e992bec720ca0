#include "ep_solver/substeps.h"

#include <cmath>

namespace heartbus::ep {

namespace {

constexpr double shortest = 5e-6; // [s]: nothing in a cell is faster
constexpr double far_below =
    1. / 10; // twice the substep gives four times the estimate; the rest is distance from the limit

} // namespace

SubstepControl::SubstepControl(const Parameters &parameters)
    : fixed_(parameters.automatic_substeps ? 0 : parameters.substeps), tolerance_(parameters.substep_tolerance) {}

int SubstepControl::divide(double step, double longest) const {
  if (fixed_ > 0)
    return fixed_;
  int n = 1;
  while (step / n > longest * (1 + 1e-9))
    n *= 2;
  return n;
}

int SubstepControl::refine(double step, int n, double estimate) const {
  if (fixed_ > 0)
    return n;
  for (; !(estimate <= tolerance_) && step / (2 * n) >= shortest; estimate /= 4)
    n *= 2;
  return n;
}

double SubstepControl::longest_next(double substep, double estimate) const {
  return estimate <= far_below * tolerance_ ? 2 * substep : substep;
}

} // namespace heartbus::ep
