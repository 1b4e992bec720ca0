#pragma once

#include "common/bus/solver.h"
#include "common/io/state.h"
#include "mech_solver/cavity.h"
#include "mech_solver/interface_wall.h"

#include <vector>

namespace heartbus::mech {

/// Blood of one pressure p in the cavity behind the interface, for a circulation in another participant. The wall is
/// solved under the guess p* = 2 p^n - p^{n-1}; then it tells its volume and how that answers to pressure,
///
///     w = A^{-1} b,    C = (V(d + w u) - V(d - w u)) / (2 u),    u = 1 Pa,
///
/// with the tangent A and the force b of a unit pressure. The circulation finds p with V + C (p - p*), and the wall
/// follows: d += (p - p*) w. What the volume misses by that is of second order in p - p*.
class CavityFilling {
 public:
  explicit CavityFilling(ElasticityProblem &problem);
  void declare(bus::Declaration &bus);
  /// After inflation to this pressure, or a state.
  void begin(double pressure, const fem::Vector &d);
  /// What the wall is to be solved under [Pa].
  double guess() const { return guess_[0]; }
  /// Of the wall's motion d under the guess. Collective, as are all below.
  void respond(const fem::Vector &d);
  void press(fem::Vector &d);
  void commit();
  void visit(io::State &state); ///< pressures
  void load(const fem::Vector &d);

 private:
  void make_guess() { guess_[0] = 2 * pressure_n_ - pressure_nm1_; }

  ElasticityProblem &problem_;
  Cavity cavity_;
  double pressure_n_ = 0, pressure_nm1_ = 0;
  PressureResponse response_;                                                          ///< w
  std::vector<double> volume_ = {0}, compliance_ = {0}, guess_ = {0}, pressure_ = {0}; ///< of the bus
};

} // namespace heartbus::mech
