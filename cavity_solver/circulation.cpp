#include "cavity_solver/circulation.h"

#include <cmath>
#include <initializer_list>

namespace heartbus::cavity {

double Circulation::solve(const CavityAnswer &cavity, double old_volume, double dt) {
  const CirculationParameters &p = parameters_;
  const auto [rest, slope] = p.arteries.answer(arterial_n_, dt);
  const double mitral = dt / p.mitral_resistance, aortic = dt / (p.aortic_resistance + slope); // [m^3/Pa]
  const double closed = old_volume - cavity.volume + cavity.compliance * cavity.pressure;      // C p, valves closed
  double pressure = closed / cavity.compliance;
  for (const bool mitral_opens : {false, true})
    for (const bool aortic_opens : {false, true}) {
      const double there = (closed + mitral_opens * mitral * p.atrial_pressure + aortic_opens * aortic * rest) /
                           (cavity.compliance + mitral_opens * mitral + aortic_opens * aortic);
      if ((there < p.atrial_pressure) == mitral_opens && (there > rest) == aortic_opens)
        pressure = there;
    }
  mitral_flow_ = std::fmax(0, p.atrial_pressure - pressure) / p.mitral_resistance;
  aortic_flow_ = std::fmax(0, pressure - rest) / (p.aortic_resistance + slope);
  arterial_ = rest + slope * aortic_flow_;
  return pressure;
}

void Circulation::commit() { arterial_n_ = arterial_; }

} // namespace heartbus::cavity
