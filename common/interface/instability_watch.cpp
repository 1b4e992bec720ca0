#include "common/interface/instability_watch.h"

#include "common/interface/alpha.h"

#include <cstdio>

namespace heartbus::interface {
namespace {

std::string rounded(double value) {
  char text[64];
  std::snprintf(text, sizeof text, "%.0f", value);
  return text;
}

std::string advice(double alpha) { return "'alpha: " + rounded(alpha) + " kg/(m^2 s)'"; }

} // namespace

std::string explanation(const Runaway &seen, double pressure) {
  const double alpha = seen.alpha, limit = seen.alpha_limit;
  const std::string observed = "blood and wall disagree by " + rounded(seen.kinematic_jump) +
                               " Pa, and more from step to step" + (seen.alternates ? ", with changing sign" : "") +
                               "; coupling.alpha is " + rounded(alpha) + " kg/(m^2 s)";
  const bool is_far_below = limit > 0 && alpha < limit / 2; // by more than any estimate is wrong
  if ((seen.alternates && !is_far_below) || (limit > 0 && alpha > limit))
    return "the coupling is unstable: " + observed + (limit > 0 ? ", wall and blood allow " + rounded(limit) : "") +
           ": write " + advice(limit > 0 ? std::min(share_of_limit * limit, 0.5 * alpha) : 0.5 * alpha) +
           (seen.automatic_alpha ? "" : " or 'alpha: auto'");
  if (limit <= 0)
    return "the coupling may be unstable: " + observed +
           ", its limit has not been estimated since the restart: see whether " + advice(0.5 * alpha) + " lasts longer";
  if (seen.iterates && alpha > limit / 2)
    return "the coupling may be unstable: " + observed + ", and the limit of " + rounded(limit) +
           " is up to half too high for iterations: see whether " + advice(0.5 * alpha) + " lasts longer";
  return "blood and wall run away from each other: " + observed + ", " + (is_far_below ? "far " : "") +
         "below the limit of " + rounded(limit) + (seen.alternates ? "" : ", and the sign does not change") +
         ", so it is not alpha; the blood's mean pressure is " + rounded(pressure) +
         " Pa: see in history.csv what drives it (tension, pressures, flows)";
}

} // namespace heartbus::interface
