#pragma once

#include "ep_solver/ionic/ionic_model.h"

namespace heartbus::ep {

/// How a cell is paced: dv/dt = I_app - I_ion, with I_app = `amplitude` for `duration` at the start of each beat.
struct Pacing {
  double cycle_length = 0.8, dt = 2e-5; ///< [s]
  Integrator integrator = Integrator::imex_euler;
  double amplitude = 52, duration = 1e-3; ///< [V/s], [s]
  bool carried_by_potassium = true;       ///< whether I_app enters the balance of K_i
};

/// What a cell does over a beat: potential [V] and calcium [uM] every `dt` [s], from the beat's begin to its end.
struct Trace {
  double dt;
  std::vector<double> v, calcium;
  /// When the potential first crosses `level` [V] after `from` [s]; the end where it never does.
  double crossing(double from, double level) const;
};
/// One beat of a single cell, which is advanced.
Trace trace(const IonicModel &model, CellState &cell, const Pacing &pacing);

/// What is reported of one beat of a single cell.
struct Beat {
  double v_diastole, v_max;                                 ///< before the stimulus, at the peak [V]
  double duration;                                          ///< APD90: from -40 mV upwards to 90 % repolarisation [s]
  double calcium_diastole, calcium_peak, calcium_peak_time; ///< [uM], [uM], [s]
};
/// The same, summarised.
Beat pace(const IonicModel &model, CellState &cell, const Pacing &pacing);

} // namespace heartbus::ep
