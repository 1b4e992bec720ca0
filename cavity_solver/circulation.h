#pragma once

#include "fluid_solver/models/windkessel.h"

namespace heartbus::cavity {

/// What the blood in the ventricle meets: an atrium of constant pressure, an aorta as a three-element Windkessel, and
/// two valves that let it pass one way.
struct CirculationParameters {
  double atrial_pressure = 1333;    ///< [Pa]
  double mitral_resistance = 1e6;   ///< of the open valve [Pa s/m^3]
  double aortic_resistance = 1.3e7; ///< of the open valve and the proximal aorta [Pa s/m^3]
  double arterial_pressure = 9000;  ///< of the vessels before the first beat [Pa]
  fluid::Windkessel arteries;
  double density = 1060;  ///< of the blood [kg/m^3]
  double mitral_area = 0; ///< effective, of the jet behind the valve [m^2]; 0: it costs no pressure
  double aortic_area = 0; ///< likewise
};

/// How the cavity answers: V(p) = volume + compliance (p - pressure).
struct CavityAnswer {
  double volume = 0, compliance = 0, pressure = 0; ///< [m^3], [m^3/Pa], [Pa]
};

/// One pressure in the whole ventricle and the flows through its valves, by implicit Euler:
///
///     V(p) = V^n + dt (Q_mitral - Q_aortic),
///     p_atrium - p = R_mitral Q_mitral + rho/2 (Q_mitral / A_mitral)^2  where that is positive, else Q_mitral = 0,
///     p - p_art = R_aortic Q_aortic + rho/2 (Q_aortic / A_aortic)^2     likewise,
///     C (p_art - p_art^n) / dt = Q_aortic - (p_art - p_venous) / R_peripheral.
///
/// The quadratic terms are the kinetic energy of the jets, which is lost; a jet is narrower than its valve. All of it
/// is solved at once with the cavity's answer, so that no volume is lost and no valve chatters. What V(p) and the
/// flows leave of the first line grows with p: there is one solution.
class Circulation {
 public:
  explicit Circulation(const CirculationParameters &parameters)
      : parameters_(parameters), arterial_(parameters.arterial_pressure), arterial_n_(arterial_) {}

  /// The pressure at the end of the step [Pa].
  double solve(const CavityAnswer &cavity, double old_volume, double dt);
  void commit();

  double mitral_flow() const { return mitral_flow_; } ///< into the ventricle [m^3/s]
  double aortic_flow() const { return aortic_flow_; } ///< out of it [m^3/s]
  double arterial_pressure() const { return arterial_; }
  bool mitral_open() const { return mitral_flow_ > 0; }
  bool aortic_open() const { return aortic_flow_ > 0; }
  /// After a commit, for states.
  double &old_arterial_pressure() { return arterial_n_; }

 private:
  CirculationParameters parameters_;
  double arterial_, arterial_n_;
  double mitral_flow_ = 0, aortic_flow_ = 0;
};

} // namespace heartbus::cavity
