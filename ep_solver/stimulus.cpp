#include "ep_solver/stimulus.h"

#include <algorithm>
#include <cmath>

namespace heartbus::ep {

namespace {

/// 1 well inside the site, 0 outside; a ball fades over the outer fifth of its radius, so that refining the mesh does
/// not switch nodes on and off.
double weight(const StimulusSite &site, const geometry::Point3 &x) {
  const double dx = x[0] - site.centre[0], dy = x[1] - site.centre[1], dz = x[2] - site.centre[2];
  if (site.shape == "cube")
    return std::max({std::abs(dx), std::abs(dy), std::abs(dz)}) <= site.radius * (1 + 1e-9) ? 1 : 0;
  const double depth = (1 - std::sqrt(dx * dx + dy * dy + dz * dz) / site.radius) / 0.2;
  return 0.5 - 0.5 * std::cos(M_PI * std::clamp(depth, 0.0, 1.0));
}

} // namespace

Stimulus::Stimulus(const StimulusParameters &parameters, const std::vector<geometry::Point3> &points)
    : amplitude_(parameters.amplitude), duration_(parameters.duration), period_(parameters.period) {
  for (const auto &x : points) {
    weights_.push_back(0);
    for (const auto &site : parameters.sites)
      weights_.back() = std::max(weights_.back(), weight(site, x));
  }
}

bool Stimulus::active(double time) const {
  const double round_off = 1e-9 * period_;
  const double phase = time - period_ * std::floor((time - round_off) / period_);
  return phase <= duration_ + round_off;
}

void Stimulus::add(double time, std::size_t n, double *i) const {
  if (active(time))
    for (std::size_t k = 0; k < n; ++k)
      i[k] += amplitude_ * weights_[k];
}

} // namespace heartbus::ep
