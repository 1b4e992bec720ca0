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
/// The paper's words are that a valve closes when its flow *becomes* null or reversed. A loosely coupled step takes the
/// wall's pressure of the step before, so that of the step that opens a valve may let a drop back (measured: 0.1 mL/s);
/// hence the first step of an open valve does not close it while the pressure keeps it open. From the second step on the flow
/// decides alone: blood that runs against the pressure must not be let back for longer.
///
/// Beyond the paper are what keeps the first decisions apart from round-off, since the beat starts in equilibrium with the
/// atrium (p0 = p_MV): a hysteresis, or a guard at the start; at most one switch a step; and, unless it is 0, a blanking
/// time. `update` decides from what the previous step has committed, so that iterations within a step see one state.
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
  /// Of the open valve, with its flow and the pressure that keeps it open.
  bool closes(double flow, double excess);

  ValveRules rules_;
  Phase phase_ = isovolumetric_contraction;
  double last_switch_ = 0; ///< the start counts as one
  bool is_new_ = false;     ///< no step of the open valve has been judged yet
};

} // namespace heartbus::fluid
