#include "ep_solver/ionic/pacing.h"

#include <algorithm>
#include <cmath>

namespace heartbus::ep {

namespace {

/// Number of the first sample after `from` on the other side of `level`, interpolated; the end when there is none.
double crossing(const std::vector<double> &v, std::size_t from, double level) {
  const bool below = v[from] < level;
  for (std::size_t n = from + 1; n < v.size(); ++n)
    if ((v[n] < level) != below)
      return n - 1 + (level - v[n - 1]) / (v[n] - v[n - 1]);
  return v.size();
}

} // namespace

Beat pace(const IonicModel &model, CellState &cell, const Pacing &pacing) {
  const double dt = pacing.dt;
  const auto n_steps = std::lround(pacing.cycle_length / dt);
  std::vector<double> v{cell.v}, calcium;
  double v_rate = 0; // over the last step
  for (long n = 0; n < n_steps; ++n) {
    calcium.push_back(model.calcium_to_micromolar() * cell.states[model.calcium_state()]);
    const double i_app = pacing.amplitude * std::clamp(pacing.duration / dt - n, 0.0, 1.0); // mean over the step
    const double v_used = pacing.integrator == Integrator::imex_euler ? cell.v : cell.v + 0.5 * dt * v_rate;
    const double i_ion =
        model.step_cell(pacing.integrator, v_used, cell.states, dt, pacing.carried_by_potassium ? i_app : 0);
    v_rate = i_app - i_ion;
    cell.v += dt * v_rate;
    v.push_back(cell.v);
  }
  const auto peak = std::max_element(v.begin(), v.end());
  const auto calcium_peak = std::max_element(calcium.begin(), calcium.end());
  const double repolarised = *peak - 0.9 * (*peak - v[0]);
  Beat beat;
  beat.v_diastole = v[0];
  beat.v_max = *peak;
  beat.duration = dt * (crossing(v, peak - v.begin(), repolarised) - crossing(v, 0, -0.04));
  beat.calcium_diastole = calcium[0];
  beat.calcium_peak = *calcium_peak;
  beat.calcium_peak_time = dt * (calcium_peak - calcium.begin());
  return beat;
}

} // namespace heartbus::ep
