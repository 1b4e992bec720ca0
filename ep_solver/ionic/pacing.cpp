#include "ep_solver/ionic/pacing.h"

#include <algorithm>
#include <cmath>

namespace heartbus::ep {

double Trace::crossing(double from, double level) const {
  std::size_t n = std::min<std::size_t>(std::llround(from / dt), v.size() - 1);
  const bool below = v[n] < level;
  for (++n; n < v.size(); ++n)
    if ((v[n] < level) != below)
      return dt * (n - 1 + (level - v[n - 1]) / (v[n] - v[n - 1]));
  return dt * v.size();
}

Trace trace(const IonicModel &model, CellState &cell, const Pacing &pacing) {
  const double dt = pacing.dt;
  const auto n_steps = std::lround(pacing.cycle_length / dt);
  const auto calcium = [&] { return model.calcium_to_micromolar() * cell.states[model.calcium_state()]; };
  Trace trace{dt, {cell.v}, {calcium()}};
  double v_rate = 0; // over the last step
  for (long n = 0; n < n_steps; ++n) {
    const double i_app = pacing.amplitude * std::clamp(pacing.duration / dt - n, 0.0, 1.0); // mean over the step
    const double v_used = pacing.integrator == Integrator::imex_euler ? cell.v : cell.v + 0.5 * dt * v_rate;
    const double i_ion =
        model.step_cell(pacing.integrator, v_used, cell.states, dt, pacing.carried_by_potassium ? i_app : 0);
    v_rate = i_app - i_ion;
    cell.v += dt * v_rate;
    trace.v.push_back(cell.v);
    trace.calcium.push_back(calcium());
  }
  return trace;
}

Beat pace(const IonicModel &model, CellState &cell, const Pacing &pacing) {
  const Trace beat = trace(model, cell, pacing);
  const double dt = beat.dt;
  const auto peak = std::max_element(beat.v.begin(), beat.v.end());
  const auto calcium_peak = std::max_element(beat.calcium.begin(), beat.calcium.end());
  const double repolarised = *peak - 0.9 * (*peak - beat.v[0]);
  Beat summary;
  summary.v_diastole = beat.v[0];
  summary.v_max = *peak;
  summary.duration = beat.crossing(dt * (peak - beat.v.begin()), repolarised) - beat.crossing(0, -0.04);
  summary.calcium_diastole = beat.calcium[0];
  summary.calcium_peak = *calcium_peak;
  summary.calcium_peak_time = dt * (calcium_peak - beat.calcium.begin());
  return summary;
}

} // namespace heartbus::ep
