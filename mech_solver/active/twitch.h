#pragma once

#include "mech_solver/active/active_model.h"

namespace heartbus::mech {

/// A twitch that calcium alone drives, the least that makes a heart beat; a surrogate, not a model of sarcomeres:
///
///     ds/dt = (h(Ca) - s)/tau,   h(Ca) = Ca^n/(Ca_50^n + Ca^n),   G(s) = s.
///
/// Force goes to Hill's curve of steady force over calcium and is late by tau, in contraction as in relaxation. Length
/// does not feed back. With the calcium of the ionic model ttp06_epi, the constants give what Rdq18Ann gives at the
/// scene's sarcomere length: a peak of about 0.2, half of it 0.15 s later. A step is exact for the calcium at its end.
class Twitch : public ActiveModel {
 public:
  static constexpr double half_calcium = 1.2, cooperativity = 3, time_constant = 0.1; ///< Ca_50 [uM], n, tau [s]
  static constexpr double calcium_at_rest = 0.1;                                      ///< [uM]

  static double steady(double calcium);
  unsigned n_states() const override { return 1; }
  std::vector<double> initial_state() const override { return {steady(calcium_at_rest)}; }
  void rate(const double *s, double calcium, double sarcomere_length, double *ds) const override;
  void advance(double dt, double calcium, double sarcomere_length, double *s) const override;
  double permissivity(const double *s) const override { return s[0]; }
  bool clamps(double) const override { return false; }
};

} // namespace heartbus::mech
