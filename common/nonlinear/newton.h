#pragma once

#include "common/base/failure.h"

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
  double growth = 1;        ///< by which an iteration may enlarge the residual
  unsigned max_iterations = 30;
};

struct NewtonStatistics {
  unsigned iterations = 0, linear_iterations = 0, tangents = 0;
  double residual = 0, scale = 0;
  double update = 0; ///< size of the last one
  double error = 0;  ///< estimate of the next one: the last times the factor by which it reduced the residual
};

/// One solve of `newton`, below.
template <class Problem, class Vector>
class NewtonIteration {
 public:
  NewtonIteration(const std::string &what, Problem &problem, Vector &x, const NewtonSettings &settings)
      : what_(what), problem_(problem), settings_(settings), x_(x), r_(x), dx_(x), trial_(x), r_trial_(x) {}

  NewtonStatistics run(const Vector *other_start) {
    begin(other_start);
    while (!is_done()) {
      if (statistics_.iterations == settings_.max_iterations)
        stop("this is the largest number allowed");
      find_direction();
      if (const auto next = search())
        take(*next);
      else if (!is_fresh_)
        linearise();
      else if (statistics_.update > settings_.update_tolerance)
        stop("no step along Newton's direction reduces the residual");
      else
        break; // the update is negligible: what is left of the residual is rounding
    }
    return statistics_;
  }

 private:
  void begin(const Vector *other_start) {
    size_ = problem_.residual(x_, r_);
    if (!size_.valid && other_start) {
      x_ = *other_start;
      size_ = problem_.residual(x_, r_);
    }
    note_size();
    if (!size_.valid) {
      problem_.refuse();
      fail("the start is not a valid state");
    }
    if (!problem_.has_tangent() && !is_small(size_, 1e-3))
      linearise();
  }

  /// Nothing to do, e.g. at rest, is told by a residual far below the tolerance; that what is left of the residual is
  /// rounding, by an update far below its tolerance.
  bool is_done() const {
    const bool is_converged =
        is_small(size_) && statistics_.iterations > 0 && statistics_.error <= settings_.update_tolerance;
    const bool is_rounding = statistics_.iterations > 0 && statistics_.update <= 1e-4 * settings_.update_tolerance;
    return is_converged || is_small(size_, 1e-3) || is_rounding;
  }

  void find_direction() {
    ++statistics_.iterations;
    refused_.reset();
    dx_ = 0;
    statistics_.linear_iterations += problem_.solve(dx_, r_);
    statistics_.update = problem_.size(dx_);
    step_ = std::min(1.0, settings_.largest_update / std::max(statistics_.update, 1e-300));
    statistics_.update *= step_;
    statistics_.error = statistics_.update;
  }

  /// The residual where the step, or a half of it, or of that, makes it small enough.
  std::optional<ResidualSize> search() {
    for (unsigned halvings = 0; halvings < 10; ++halvings) {
      if (halvings > 0)
        step_ /= 2;
      trial_ = x_;
      trial_.add(step_, dx_);
      const ResidualSize next = problem_.residual(trial_, r_trial_);
      if (!next.valid)
        refused_ = trial_;
      if (next.valid && std::isfinite(next.norm) &&
          (next.norm <= settings_.growth * (1 - 1e-4 * step_) * size_.norm || is_small(next)))
        return next;
    }
    return {};
  }

  void take(const ResidualSize &next) {
    const bool is_slow = !(next.norm <= settings_.contraction * size_.norm) && !is_small(next);
    statistics_.error *= size_.norm > 0 ? std::min(1.0, next.norm / size_.norm) : 0;
    x_.swap(trial_);
    r_.swap(r_trial_);
    size_ = next;
    note_size();
    is_fresh_ = false;
    if (is_slow)
      linearise();
  }

  void linearise() {
    problem_.linearise(x_);
    ++statistics_.tangents;
    is_fresh_ = true;
  }
  void note_size() {
    statistics_.residual = size_.norm;
    statistics_.scale = size_.scale;
  }
  bool is_small(const ResidualSize &size, double factor = 1) const {
    return size.norm <= factor * settings_.residual_tolerance * size.scale;
  }

  /// When Newton's method is stopped by the borders of what is allowed, they are the cause rather than it.
  [[noreturn]] void stop(const std::string &why) {
    if (refused_) {
      problem_.residual(*refused_, r_trial_);
      problem_.refuse();
    }
    fail(why + (refused_ ? ", since states along it are not valid" : ""));
  }
  [[noreturn]] void fail(const std::string &why) const {
    std::ostringstream message;
    message << what_ << ": Newton stopped after " << statistics_.iterations << " iterations, because " << why
            << ": residual " << statistics_.residual << " where " << settings_.residual_tolerance * statistics_.scale
            << " is wanted, next update about " << statistics_.error << " where " << settings_.update_tolerance
            << " is wanted";
    throw Failure(ExitCode::not_converged, message.str());
  }

  const std::string what_;
  Problem &problem_;
  const NewtonSettings settings_;
  Vector &x_;
  Vector r_, dx_, trial_, r_trial_;
  NewtonStatistics statistics_;
  ResidualSize size_;
  double step_ = 1;
  bool is_fresh_ = false;         ///< the tangent is that of x
  std::optional<Vector> refused_; ///< the last trial of the last iteration that was not valid, if any was
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
  return NewtonIteration<Problem, Vector>(what, problem, x, settings).run(other_start);
}

} // namespace heartbus::fem
