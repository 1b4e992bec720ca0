#include "ep_solver/stimulus.h"

#include "common/base/failure.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

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

double distance(const geometry::Point3 &x, const std::vector<double> &centre) {
  return std::sqrt(std::pow(x[0] - centre[0], 2) + std::pow(x[1] - centre[1], 2) + std::pow(x[2] - centre[2], 2));
}

std::string in_mm(double length) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", 1e3 * length);
  return text;
}

constexpr double half_way = 0.9; // of a ball's radius, where the weight is a half

} // namespace

geometry::Point3 nearest_in(const StimulusSite &site, const geometry::Point3 &x) {
  geometry::Point3 nearest = x;
  const double r = distance(x, site.centre), radius = half_way * site.radius;
  for (unsigned i = 0; i < 3; ++i) {
    const double c = site.centre[i];
    if (site.shape == "cube")
      nearest[i] = std::clamp(x[i], c - site.radius, c + site.radius);
    else if (r > radius)
      nearest[i] = c + radius / r * (x[i] - c);
  }
  return nearest;
}

bool is_in(const StimulusSite &site, const geometry::Point3 &x) {
  const geometry::Point3 nearest = nearest_in(site, x);
  return distance(x, {nearest.begin(), nearest.end()}) <= 1e-9 * site.radius;
}

void check_reach(const std::vector<StimulusSite> &sites, const std::vector<geometry::Point3> &points,
                 MPI_Comm communicator,
                 const std::function<bool(const StimulusSite &, const geometry::Point3 &)> &reaches) {
  for (std::size_t k = 0; k < sites.size(); ++k) {
    const StimulusSite &site = sites[k];
    double local[2] = {0, -std::numeric_limits<double>::infinity()}, all[2]; // whether reached, - smallest distance
    for (const auto &x : points) {
      local[0] = std::max(local[0], double(reaches(site, x)));
      local[1] = std::max(local[1], -distance(x, site.centre));
    }
    MPI_Allreduce(local, all, 2, MPI_DOUBLE, MPI_MAX, communicator);
    if (all[0] > 0)
      continue;
    throw Failure(ExitCode::scene, "electrophysiology.stimulus: site " + std::to_string(k + 1) + ", a " + site.shape +
                                       " of radius " + in_mm(site.radius) + " mm around [" + in_mm(site.centre[0]) +
                                       ", " + in_mm(site.centre[1]) + ", " + in_mm(site.centre[2]) +
                                       "] mm, reaches no node; the nearest is " + in_mm(-all[1]) +
                                       " mm from its centre: move the site or enlarge it");
  }
}

Stimulus::Stimulus(const StimulusParameters &parameters, const std::vector<geometry::Point3> &points,
                   MPI_Comm communicator)
    : amplitude_(parameters.amplitude), duration_(parameters.duration), period_(parameters.period) {
  check_reach(parameters.sites, points, communicator,
              [](const StimulusSite &site, const geometry::Point3 &x) { return weight(site, x) > 0; });
  for (const auto &x : points) {
    weights_.push_back(0);
    for (const auto &site : parameters.sites)
      weights_.back() = std::max(weights_.back(), weight(site, x));
  }
}

double Stimulus::time_on(double time) const {
  const double periods = std::floor(time / period_);
  return periods * duration_ + std::min(time - periods * period_, duration_);
}

double Stimulus::share(double begin, double end) const {
  const double share = (time_on(end) - time_on(begin)) / (end - begin);
  constexpr double round_off = 1e-9; // of the times
  return share < round_off ? 0 : share > 1 - round_off ? 1 : share;
}

void Stimulus::add(double begin, double end, std::size_t n, double *i) const {
  const double mean = amplitude_ * share(begin, end);
  if (mean != 0)
    for (std::size_t k = 0; k < n; ++k)
      i[k] += mean * weights_[k];
}

} // namespace heartbus::ep
