#pragma once

#include "common/geometry/mesh.h"
#include "ep_solver/settings/parameters.h"

#include <functional>
#include <mpi.h>
#include <vector>

namespace heartbus::ep {

/// Whether a front starts at x: where the current is half of its amplitude at least, in a ball within 0.9 of its
/// radius.
bool is_in(const StimulusSite &site, const geometry::Point3 &x);
/// The point of it that is nearest to x.
geometry::Point3 nearest_in(const StimulusSite &site, const geometry::Point3 &x);

/// Collective. Failure(scene), on all ranks the same, when a site reaches no point of any rank.
void check_reach(const std::vector<StimulusSite> &sites, const std::vector<geometry::Point3> &points,
                 MPI_Comm communicator,
                 const std::function<bool(const StimulusSite &, const geometry::Point3 &)> &reaches);

/// The applied current I_app(x, t) at given points, on during the first `duration` of each period. A step is given its
/// mean over that step, so that steps of any length deliver the same charge.
class Stimulus {
 public:
  /// Collective. Failure(scene) when a site reaches no point of any rank.
  Stimulus(const StimulusParameters &parameters, const std::vector<geometry::Point3> &points, MPI_Comm communicator);
  /// Share of the time from `begin` to `end` [s] during which the current is on.
  double share(double begin, double end) const;
  /// i[point] += mean of I_app(x, t) over the time from `begin` to `end` [V/s], for the first `n` points.
  void add(double begin, double end, std::size_t n, double *i) const;

 private:
  double time_on(double time) const; ///< how long the current has been on since the start [s]

  double amplitude_, duration_, period_;
  std::vector<double> weights_; ///< [point], between 0 and 1
};

} // namespace heartbus::ep
