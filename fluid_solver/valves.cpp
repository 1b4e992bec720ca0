#include "fluid_solver/valves.h"

#include <cstdio>
#include <utility>

namespace heartbus::fluid {
namespace {

std::string sentence(const char *format, double a, double b) {
  char text[160];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

} // namespace

const std::vector<std::string> &Valves::phase_names() {
  static const std::vector<std::string> names{"isovolumetric contraction", "ejection", "isovolumetric relaxation",
                                              "filling", "diastasis"};
  return names;
}

std::optional<std::string> Valves::update(double t, double pressure, double mitral_flow, double aortic_flow) {
  if (t - last_switch_ < rules_.blanking)
    return {};
  const auto reason = decide(t, pressure, mitral_flow, aortic_flow);
  if (reason) {
    last_switch_ = t;
    is_new_ = true;
  }
  return reason;
}

void Valves::visit(io::State &state) {
  double phase = phase_;
  state.number("phase", phase);
  phase_ = static_cast<Phase>(static_cast<int>(phase));
  state.number("last_switch", last_switch_);
  double is_new = is_new_;
  state.number("is_new", is_new);
  is_new_ = is_new != 0;
}

bool Valves::closes(double flow, double excess) {
  const bool first = std::exchange(is_new_, false);
  return flow <= 0 && !(first && excess > 0);
}

/// Both valves are never open at once: an open one must close before the other may open.
std::optional<std::string> Valves::decide(double t, double pressure, double mitral_flow, double aortic_flow) {
  if (phase_ == ejection) {
    if (!closes(aortic_flow, pressure - rules_.aortic_pressure))
      return {};
    phase_ = isovolumetric_relaxation;
    return sentence("aortic valve closes: its flow %.3g mL/s is not outwards (pressure %.5g Pa)", 1e6 * aortic_flow,
                    pressure);
  }
  if (phase_ == filling) {
    if (!closes(mitral_flow, rules_.mitral_pressure - pressure))
      return {};
    phase_ = diastasis;
    return sentence("mitral valve closes: its flow %.3g mL/s is not inwards (pressure %.5g Pa)", 1e6 * mitral_flow,
                    pressure);
  }
  // Behind closed valves the pressure rises beyond the atrium's when the wall contracts: the next beat has begun.
  if (phase_ == diastasis && pressure > rules_.mitral_pressure + rules_.hysteresis)
    phase_ = isovolumetric_contraction;
  if (pressure > rules_.aortic_pressure + rules_.hysteresis) {
    phase_ = ejection;
    return sentence("aortic valve opens: pressure %.6g Pa exceeds the aorta's %.6g Pa", pressure,
                    rules_.aortic_pressure);
  }
  if (pressure < rules_.mitral_pressure - rules_.hysteresis && t >= rules_.mitral_guard) {
    phase_ = filling;
    return sentence("mitral valve opens: pressure %.6g Pa is below the atrium's %.6g Pa", pressure,
                    rules_.mitral_pressure);
  }
  return {};
}

} // namespace heartbus::fluid
