#pragma once

#include "ep_solver/ionic/pacing.h"

namespace heartbus::ep {

/// Potential and calcium of a cell that is activated once a period, for ever: its limit cycle, over the time since its
/// activation, when the potential passes 0 V upwards.
class Transient {
 public:
  /// Paces the cell from the limit cycle or the published state (ionic_model.h) until calcium repeats itself within a
  /// ten-thousandth of its peak. Failure(scene) when a beat activates no cell.
  Transient(const IonicModel &model, const std::string &initial_state, double period);

  /// `phase` [s]: any; what lies outside of the period counts as of the beats before and after; NaN: at rest.
  double potential(double phase) const { return at(trace_.v, phase); }     ///< [V]
  double calcium(double phase) const { return at(trace_.calcium, phase); } ///< [uM]
  double repolarisation() const { return repolarisation_; }                ///< phase [s] at which it passes -70 mV

 private:
  double at(const std::vector<double> &values, double phase) const;
  double period_, activation_, repolarisation_;
  Trace trace_;
};

/// How long a stimulus of this amplitude [V/s] and duration [s] takes to activate a cell at rest [s]. Failure(scene)
/// when it does not.
double latency(const IonicModel &model, const std::string &initial_state, double amplitude, double duration);

} // namespace heartbus::ep
