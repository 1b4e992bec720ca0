#pragma once

#include "common/config/section.h"

namespace heartbus {

/// Whether a time is a whole number of steps.
bool is_multiple(double whole, double part);

/// A run is so many beats long, each of one period of the stimulus, or ends at a time of its own.
struct TimeParameters {
  int beats = 1;             ///< of the run; 0: `end` was given instead
  bool whole_beats = true;   ///< the end is that of the last beat
  double end = 0.8;          ///< [s]
  double period = 0.8;       ///< of a beat: from one stimulus to the next [s]
  double until_periodic = 0; ///< share by which beats in a row may differ for the run to end; 0: it does not end early
  double step = 0.2e-3;      ///< [s]
  int n_steps() const;
  void describe(config::Section &section);
  /// Once the period is known: the end of the last beat. Fails on what contradicts itself.
  void settle(config::Section &section, double stimulus_period);
};

} // namespace heartbus
