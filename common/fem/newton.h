#pragma once

#include "common/bus/failure.h"

#include <cmath>
#include <limits>
#include <optional>
#include <sstream>
#include <string>

namespace heartbus::fem {

/// Value of a residual at a trial state.
struct ResidualSize {
  bool valid = true; ///< false: the state is outside what the model allows, e.g. an inverted cell
  double norm = 0;
  double scale = 0; ///< of the terms that balance in it; what the norm is compared with
};

struct NewtonSettings {
  double residual_tolerance = 1e-8; ///< relative to ResidualSize::scale
  double update_tolerance = 1e-8;   ///< of the next update's size, which would be about the error
  double largest_update = std::numeric_limits<double>::infinity();
  double contraction = 0.1; ///< an iteration that reduces the residual less than this asks for a new tangent
  double growth = 1; ///< by which an iteration may enlarge the residual
  unsigned max_iterations = 30;
};

struct NewtonStatistics {
  unsigned iterations = 0, linear_iterations = 0, tangents = 0;
  double residual = 0, scale = 0;
  double update = 0; ///< size of the last one
  double error = 0;  ///< estimate of the next one: the last times the factor by which it reduced the residual
};

/// Newton's method with backtracking for r(x) = 0 that keeps its tangent for as long as that contracts well: within the
/// solve and, since the problem holds the tangent, from one solve to the next. The residual is always exact. Converged
/// means that the residual is small and that the next update would be (the monitor of simplified Newton methods, P.
/// Deuflhard, Newton Methods for Nonlinear Problems, doi:10.1007/978-3-642-23899-4, section 2.1). The problem offers:
///
///     ResidualSize residual(const Vector &x, Vector &r);
///     bool has_tangent() const;
///     void linearise(const Vector &x);
///     unsigned solve(Vector &dx, const Vector &r);   // tangent dx = -r, returns linear iterations
///     double size(const Vector &dx) const;           // what the update tolerances are compared with
///     void refuse() const;                           // throws what is wrong with the last state, which was not valid
///
/// That is also thrown when Newton's method stops because the states along its direction are not valid.
///
/// Throws Failure(not_converged) that says where it stopped and why. When the start is not valid, it is `other_start`,
/// which must be.
template <class Problem, class Vector>
NewtonStatistics newton(const std::string &what, Problem &problem, Vector &x, const NewtonSettings &settings,
                        const Vector *other_start = nullptr) {
  NewtonStatistics statistics;
  Vector r(x), dx(x), trial(x), r_trial(x);
  const auto fail = [&](const std::string &why) {
    std::ostringstream message;
    message << what << ": Newton stopped after " << statistics.iterations << " iterations, because " << why
            << ": residual " << statistics.residual << " where " << settings.residual_tolerance * statistics.scale
            << " is wanted, next update about " << statistics.error << " where " << settings.update_tolerance
            << " is wanted";
    throw Failure(ExitCode::not_converged, message.str());
  };
  std::optional<Vector> refused; // the last trial of the last iteration that was not valid, if any was
  // When Newton's method is stopped by the borders of what is allowed, they are the cause rather than it.
  const auto stop = [&](const std::string &why) {
    if (refused) {
      problem.residual(*refused, r_trial);
      problem.refuse();
    }
    fail(why + (refused ? ", since states along it are not valid" : ""));
  };
  const auto linearise = [&] {
    problem.linearise(x);
    ++statistics.tangents;
  };
  // An update far below its tolerance means that what is left of the residual is rounding.
  const auto only_rounding_left = [&] {
    return statistics.iterations > 0 && statistics.update <= 1e-4 * settings.update_tolerance;
  };
  const auto small = [&](const ResidualSize &size, double factor) {
    return size.norm <= factor * settings.residual_tolerance * size.scale;
  };

  ResidualSize size = problem.residual(x, r);
  if (!size.valid && other_start) {
    x = *other_start;
    size = problem.residual(x, r);
  }
  statistics.residual = size.norm;
  statistics.scale = size.scale;
  if (!size.valid) {
    problem.refuse();
    fail("the start is not a valid state");
  }
  bool fresh = false;
  if (!problem.has_tangent() && !small(size, 1e-3)) {
    linearise();
    fresh = true;
  }
  // Nothing to do, e.g. at rest, is told by a residual far below the tolerance.
  while (!(small(size, 1) && statistics.iterations > 0 && statistics.error <= settings.update_tolerance) &&
         !small(size, 1e-3) && !only_rounding_left()) {
    if (statistics.iterations == settings.max_iterations)
      stop("this is the largest number allowed");
    ++statistics.iterations;
    refused.reset();
    dx = 0;
    statistics.linear_iterations += problem.solve(dx, r);
    statistics.update = problem.size(dx);
    double step = std::min(1.0, settings.largest_update / std::max(statistics.update, 1e-300));
    statistics.update *= step;
    statistics.error = statistics.update;

    ResidualSize next;
    bool accepted = false;
    for (unsigned halvings = 0; halvings < 10 && !accepted; ++halvings) {
      if (halvings > 0)
        step /= 2;
      trial = x;
      trial.add(step, dx);
      next = problem.residual(trial, r_trial);
      if (!next.valid)
        refused = trial;
      accepted =
          next.valid && std::isfinite(next.norm) &&
          (next.norm <= settings.growth * (1 - 1e-4 * step) * size.norm || small(next, 1));
    }
    if (accepted) {
      const bool slow = !(next.norm <= settings.contraction * size.norm) && !small(next, 1);
      statistics.error *= size.norm > 0 ? std::min(1.0, next.norm / size.norm) : 0;
      x.swap(trial);
      r.swap(r_trial);
      size = next;
      statistics.residual = size.norm;
      statistics.scale = size.scale;
      fresh = slow;
      if (slow)
        linearise();
    } else if (!fresh) {
      linearise();
      fresh = true;
    } else if (statistics.update > settings.update_tolerance)
      stop("no step along Newton's direction reduces the residual");
    else
      break; // the update is negligible: what is left of the residual is rounding
  }
  return statistics;
}

} // namespace heartbus::fem
