#pragma once

#include <string>

namespace heartbus::fluid {

/// What comes in through an open part of the boundary.
struct Inflow {
  double flow = 0;  ///< [m^3/s]
  double power = 0; ///< kinetic energy that it brings, int rho/2 |u|^2 |u.n| [W]
  double energy() const { return flow > 0 ? power / flow : 0; } ///< per volume [Pa]
};

/// Recognises inflow that runs away. With sigma n = -p n blood comes in with its kinetic energy for free: where the
/// flow is uneven, fast blood lets in faster blood, until cells are inverted or the coupling fails
/// (docs/decisions/006). Blood at rest that is pushed in by a pressure gets no more energy per volume than that
/// pressure (Bernoulli); jets through an orifice of a coarse mesh have a few times the mean. Hence the measure:
/// energy per volume over the largest push since the orifice opened. A beat has 2 to 4, the runaway passes 100 some
/// 10 ms before anything else fails.
class InflowWatch {
 public:
  /// A new opening begins.
  void reset() { push_ = smallest_push; }
  /// One more step: the pressure outside less the blood's mean [Pa].
  void add(double push) { push_ = push > push_ ? push : push_; }
  double push() const { return push_; } ///< the largest so far [Pa], 100 at least
  /// Whether so much energy per volume [Pa] can only be that of a runaway, or hints at it when something else fails.
  bool is_runaway(double energy) const { return energy > 100 * push_; }
  bool is_suspect(double energy) const { return energy > 10 * push_; }

 private:
  static constexpr double smallest_push = 100; // below, nothing is fast
  double push_ = smallest_push;
};

/// What is seen, and the key to change.
std::string explanation(const std::string &orifice, const Inflow &inflow, double push, double backflow);

} // namespace heartbus::fluid
