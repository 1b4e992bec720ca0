#pragma once

#include "ep_solver/ionic/ionic_model.h"

namespace heartbus::ep {

/// What is reported of one beat of a single cell.
struct Beat {
  double v_diastole, v_max;                                 ///< before the stimulus, at the peak [V]
  double duration;                                          ///< APD90: from -40 mV upwards to 90 % repolarisation [s]
  double calcium_diastole, calcium_peak, calcium_peak_time; ///< [uM], [uM], [s]
};

/// One beat of a single cell, dv/dt = I_app - I_ion, stimulated with 52 V/s for 1 ms at its start. `cell` is advanced.
Beat pace(const IonicModel &model, CellState &cell, double cycle_length, double dt);

} // namespace heartbus::ep
