#pragma once

#include "common/io/state.h"

#include <optional>
#include <string>
#include <vector>

namespace heartbus::fluid {

/// When the two valves of the left ventricle switch.
struct ValveRules {
  double mitral_pressure = 1333;  ///< p_MV, upstream of the mitral valve [Pa]
  double aortic_pressure = 9000;  ///< p_AV0, downstream of the aortic valve at rest [Pa]
  double hysteresis = 10;         ///< a closed valve opens only beyond this excess of pressure [Pa]
  double blanking = 0;            ///< no switch so soon after another one [s]
  double mitral_guard = 20e-3;    ///< the mitral valve stays closed so long after the start [s]
};

/// Passive valves (paper, section 2.7): each opens when the pressure upstream exceeds that downstream and closes when the
/// flow through it vanishes or reverses. Both start closed.
///
/// The rules beyond the paper keep decisions apart from round-off and from the pressure jump of a switch: a hysteresis, a
/// blanking time, at most one switch a step, and a guard at the start, where the ventricle is in equilibrium with the
/// atrium. `update` decides from what the previous step has committed, so that iterations within a step see one state.
class Valves {
 public:
  enum Phase { isovolumetric_contraction, ejection, isovolumetric_relaxation, filling, diastasis };
  static const std::vector<std::string> &phase_names();

  explicit Valves(const ValveRules &rules) : rules_(rules) {}

  /// Decides at time t (since the start) from the ventricle's pressure and the flows into it through the mitral and out of
  /// it through the aortic valve [m^3/s]. Says which valve switched and why, if one did.
  std::optional<std::string> update(double t, double pressure, double mitral_flow, double aortic_flow);

  /// To be saved or loaded.
  void visit(io::State &state);

  bool mitral_open() const { return phase_ == filling; }
  bool aortic_open() const { return phase_ == ejection; }
  Phase phase() const { return phase_; }

 private:
  std::optional<std::string> decide(double t, double pressure, double mitral_flow, double aortic_flow);

  ValveRules rules_;
  Phase phase_ = isovolumetric_contraction;
  double last_switch_ = 0; ///< the start counts as one
};

} // namespace heartbus::fluid
