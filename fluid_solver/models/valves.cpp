#include "fluid_solver/models/valves.h"

#include <algorithm>
#include <cstdio>

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

std::optional<std::string> Valves::update(double t, double mean_pressure, const AtOrifice &mitral,
                                          const AtOrifice &aortic) {
  if (t - last_switch_ < rules_.blanking)
    return {};
  const auto reason = decide(t, mean_pressure, mitral, aortic);
  if (reason)
    last_switch_ = t;
  return reason;
}

void Valves::visit(io::State &state) {
  double phase = phase_;
  state.number("phase", phase);
  phase_ = static_cast<Phase>(static_cast<int>(phase));
  state.number("last_switch", last_switch_);
}

/// Both valves are never open at once: an open one must close before the other may open.
std::optional<std::string> Valves::decide(double t, double mean_pressure, const AtOrifice &mitral,
                                          const AtOrifice &aortic) {
  if (phase_ == ejection) {
    if (aortic.flow > 0)
      return {};
    phase_ = isovolumetric_relaxation;
    return sentence("aortic valve closes: its flow %.3g mL/s is not outwards (pressure %.5g Pa)", 1e6 * aortic.flow,
                    aortic.pressure);
  }
  if (phase_ == filling) {
    if (mitral.flow > 0)
      return {};
    phase_ = diastasis;
    return sentence("mitral valve closes: its flow %.3g mL/s is not inwards (pressure %.5g Pa)", 1e6 * mitral.flow,
                    mitral.pressure);
  }
  const double pushes_out = std::min(mean_pressure, aortic.pressure),
               lets_in = std::max(mean_pressure, mitral.pressure);
  // Behind closed valves the pressure rises beyond the atrium's when the wall contracts: the next beat has begun.
  if (phase_ == diastasis && mean_pressure > rules_.mitral_pressure + rules_.hysteresis)
    phase_ = isovolumetric_contraction;
  if (pushes_out > rules_.aortic_pressure + rules_.hysteresis) {
    phase_ = ejection;
    return sentence("aortic valve opens: pressure %.6g Pa exceeds the aorta's %.6g Pa", pushes_out,
                    rules_.aortic_pressure);
  }
  if (lets_in < rules_.mitral_pressure - rules_.hysteresis && t >= rules_.mitral_guard) {
    phase_ = filling;
    return sentence("mitral valve opens: pressure %.6g Pa is below the atrium's %.6g Pa", lets_in,
                    rules_.mitral_pressure);
  }
  return {};
}

} // namespace heartbus::fluid
