#pragma once

#include "mech_solver/active/active_model.h"

namespace heartbus::mech {

/// Neural network with two states that reproduces the RDQ18 model of cooperative sarcomere activation
/// (Regazzoni, Dede', Quarteroni 2020, doi:10.1016/j.cma.2020.113268; RDQ18: doi:10.1007/s10237-018-1049-0):
///
///     ds/dt = W2 tanh(W1 tanh(W0 x - b0) - b1) - b2,   x = (calcium [uM], sarcomere length [um], s0, s1),   G(s) = s0.
///
/// Forward Euler: the largest eigenvalue along a beat is about 43/s, so steps of 0.2 ms are far from the limit. The
/// sarcomere length is clamped to the range the network was trained on.
class Rdq18Ann : public ActiveModel {
 public:
  static constexpr double shortest = 1.7, longest = 2.3; ///< trained sarcomere lengths [um]

  unsigned n_states() const override { return 2; }
  std::vector<double> initial_state() const override;
  void rate(const double *s, double calcium, double sarcomere_length, double *ds) const override;
  void advance(double dt, double calcium, double sarcomere_length, double *s) const override;
  double permissivity(const double *s) const override { return s[0]; }
  bool clamps(double sarcomere_length) const override {
    return sarcomere_length < shortest || sarcomere_length > longest;
  }
};

} // namespace heartbus::mech
