#include "cavity_solver/circulation.h"

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <tuple>

namespace heartbus::cavity {

namespace {

/// Q of dp = R Q + rho/2 (Q / A)^2, nothing backwards.
double flow(double dp, double resistance, double density, double area) {
  const double jet = area > 0 ? density / (2 * area * area) : 0;
  return dp > 0 ? 2 * dp / (resistance + std::sqrt(resistance * resistance + 4 * jet * dp)) : 0;
}

} // namespace

double Circulation::solve(const CavityAnswer &cavity, double old_volume, double dt) {
  const CirculationParameters &p = parameters_;
  const auto [rest, slope] = p.arteries.answer(arterial_n_, dt);
  const double downstream = rest, resistance = p.aortic_resistance + slope;
  const auto defect = [&](double pressure) {
    mitral_flow_ = flow(p.atrial_pressure - pressure, p.mitral_resistance, p.density, p.mitral_area);
    aortic_flow_ = flow(pressure - downstream, resistance, p.density, p.aortic_area);
    return cavity.volume + cavity.compliance * (pressure - cavity.pressure) - old_volume -
           dt * (mitral_flow_ - aortic_flow_);
  };
  const double closed = cavity.pressure + (old_volume - cavity.volume) / cavity.compliance; // p, valves closed
  double low = std::min(closed, rest), high = std::max(closed, p.atrial_pressure), pressure = closed;
  if (closed < p.atrial_pressure || closed > rest) {
    std::uintmax_t most = 200;
    std::tie(low, high) =
        boost::math::tools::toms748_solve(defect, low, high, boost::math::tools::eps_tolerance<double>(52), most);
    pressure = std::abs(defect(low)) < std::abs(defect(high)) ? low : high;
  }
  defect(pressure);
  arterial_ = rest + slope * aortic_flow_;
  return pressure;
}

void Circulation::commit() { arterial_n_ = arterial_; }

} // namespace heartbus::cavity
