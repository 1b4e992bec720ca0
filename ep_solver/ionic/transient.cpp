#include "ep_solver/ionic/transient.h"

#include "common/base/failure.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace heartbus::ep {

namespace {

constexpr double repolarised = -70e-3; // [V], as in EPSolver
constexpr int most_beats = 1000;

/// Of the same length.
double largest_difference(const std::vector<double> &a, const std::vector<double> &b) {
  double largest = 0;
  for (std::size_t k = 0; k < a.size(); ++k)
    largest = std::max(largest, std::abs(a[k] - b[k]));
  return largest;
}

Trace limit_cycle(const IonicModel &model, const std::string &initial_state, double period) {
  Pacing pacing;
  pacing.cycle_length = period;
  pacing.dt = period / std::ceil(period / 5e-5);
  pacing.integrator = Integrator::exponential_midpoint;
  CellState cell = model.initial_state(initial_state);
  Trace last = trace(model, cell, pacing);
  for (int beat = 1; beat < most_beats; ++beat) {
    Trace next = trace(model, cell, pacing);
    const double peak = *std::max_element(next.calcium.begin(), next.calcium.end());
    const bool repeats = largest_difference(next.calcium, last.calcium) <= 1e-4 * peak;
    last = std::move(next);
    if (repeats)
      break;
  }
  return last;
}

} // namespace

Transient::Transient(const IonicModel &model, const std::string &initial_state, double period)
    : period_(period), trace_(limit_cycle(model, initial_state, period)) {
  activation_ = trace_.crossing(0, 0);
  repolarisation_ = trace_.crossing(activation_, repolarised) - activation_;
  if (activation_ + repolarisation_ > period)
    throw Failure(ExitCode::scene, "a cell that is paced every " + std::to_string(1e3 * period) +
                                       " ms is not activated or does not repolarise: "
                                       "take a longer electrophysiology.stimulus.period");
}

double Transient::at(const std::vector<double> &values, double phase) const {
  if (std::isnan(phase))
    return values.front();
  const double time = phase + activation_, in_beat = time - period_ * std::floor(time / period_);
  const double place = in_beat / trace_.dt;
  const std::size_t k = std::min<std::size_t>(place, values.size() - 2);
  const double share = std::min(place - k, 1.);
  return (1 - share) * values[k] + share * values[k + 1];
}

double latency(const IonicModel &model, const std::string &initial_state, double amplitude, double duration) {
  CellState cell = model.initial_state(initial_state);
  const double watched = duration + 20e-3; // [s]
  const Trace start = trace(model, cell, {watched, 1e-5, Integrator::exponential_midpoint, amplitude, duration, false});
  const double activation = start.crossing(0, 0);
  if (activation > watched)
    throw Failure(ExitCode::scene, "electrophysiology.stimulus activates no cell: raise its amplitude or duration");
  return activation;
}

} // namespace heartbus::ep
