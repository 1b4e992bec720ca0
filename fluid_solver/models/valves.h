#pragma once

#include "common/io/state.h"

#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace heartbus::fluid {

/// When the two valves of the left ventricle switch.
struct ValveRules {
  double mitral_pressure = 1333; ///< p_MV, upstream of the mitral valve [Pa]
  double aortic_pressure = 9000; ///< p_AV0, downstream of the aortic valve at rest [Pa]
  double hysteresis = 10;        ///< a closed valve opens only beyond this excess of pressure [Pa]
  double blanking = 0;           ///< no switch so soon after another one [s]
  double mitral_guard = 20e-3;   ///< the mitral valve stays closed so long after the start [s]
};

/// What the blood does at an orifice.
struct AtOrifice {
  double pressure = 0; ///< of the ventricle's blood, mean over the orifice [Pa]
  double flow = 0;     ///< in the direction in which the valve lets it pass [m^3/s]
};

/// Passive valves (paper, section 2.7): each opens when the pressure upstream exceeds that downstream and closes when
/// the flow through it vanishes or reverses. Both start closed.
///
/// A valve opens when both the mean pressure of the cavity and that at the orifice are beyond the pressure on the other
/// side. While the ventricle contracts behind closed valves its blood is accelerated towards the apex or the base,
/// and the mean may be above the aorta's while the blood at the valve is not: a valve that goes by the mean opens to
/// a reverse flow (measured on MXS, monolithic: 0.5 mL/s, and chatter). And in the steps after a valve has closed the
/// pressure at the orifice has a peak of some ten Pa, since flow there was stopped within a step, that the cavity
/// does not see.
///
/// Beyond the paper are what keeps the first decisions apart from round-off, since the beat starts in equilibrium
/// with the atrium (p0 = p_MV): a hysteresis, or a guard at the start; at most one switch a step; and, unless it is
/// 0, a blanking time. `update` decides from what the previous step has committed, so that iterations within a step
/// see one state.
class Valves {
 public:
  enum Phase { isovolumetric_contraction, ejection, isovolumetric_relaxation, filling, diastasis };
  static const std::vector<std::string> &phase_names();

  explicit Valves(const ValveRules &rules) : rules_(rules) {}

  /// Decides at time t (since the start) with the mean pressure of the cavity [Pa]. Says which valve switched and
  /// why, if one did.
  std::optional<std::string> update(double t, double mean_pressure, const AtOrifice &mitral, const AtOrifice &aortic);

  /// Where the wall's motion is prescribed, and with it the flow: one of the two is always open, the aortic valve while
  /// the cavity shrinks, the mitral one at first and while it grows. While it rests they stay.
  void follow(double volume_rate) {
    constexpr double round_off = 1e-9; // of a cavity that rests [m^3/s]
    if (std::abs(volume_rate) > round_off || !(aortic_open() || mitral_open()))
      phase_ = volume_rate < -round_off ? ejection : filling;
  }

  /// Of an aorta whose pressure changes: that downstream of its valve [Pa].
  void set_aortic_pressure(double pressure) { rules_.aortic_pressure = pressure; }

  /// To be saved or loaded.
  void visit(io::State &state);

  bool mitral_open() const { return phase_ == filling; }
  bool aortic_open() const { return phase_ == ejection; }
  Phase phase() const { return phase_; }

 private:
  std::optional<std::string> decide(double t, double mean_pressure, const AtOrifice &mitral, const AtOrifice &aortic);

  ValveRules rules_;
  Phase phase_ = isovolumetric_contraction;
  double last_switch_ = 0; ///< the start counts as one
};

} // namespace heartbus::fluid
