#pragma once

#include "common/geometry/mesh.h"
#include "ep_solver/parameters.h"

#include <vector>

namespace heartbus::ep {

/// The applied current I_app(x, t) at given points: on during (0, duration] of each period, so that a step that ends at
/// a time t with the paper's I_app^{n+1} = I_app(t^{n+1}) delivers the whole charge.
class Stimulus {
 public:
  Stimulus(const StimulusParameters &parameters, const std::vector<geometry::Point3> &points);
  bool active(double time) const;
  /// i[point] += I_app(x, time) [V/s], for the first `n` points.
  void add(double time, std::size_t n, double *i) const;

 private:
  double amplitude_, duration_, period_;
  std::vector<double> weights_; ///< [point], between 0 and 1
};

} // namespace heartbus::ep
