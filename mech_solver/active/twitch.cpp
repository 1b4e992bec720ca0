#include "mech_solver/active/twitch.h"

#include <cmath>

namespace heartbus::mech {

std::unique_ptr<ActiveModel> make_twitch() { return std::make_unique<Twitch>(); }

double Twitch::steady(double calcium) {
  const double bound = std::pow(calcium, cooperativity);
  return bound / (std::pow(half_calcium, cooperativity) + bound);
}

void Twitch::rate(const double *s, double calcium, double, double *ds) const {
  ds[0] = (steady(calcium) - s[0]) / time_constant;
}

void Twitch::advance(double dt, double calcium, double, double *s) const {
  const double goal = steady(calcium);
  s[0] = goal + (s[0] - goal) * std::exp(-dt / time_constant);
}

} // namespace heartbus::mech
