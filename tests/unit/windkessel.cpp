#include "fluid_solver/models/windkessel.h"

#include <cmath>
#include <gtest/gtest.h>

using heartbus::fluid::Windkessel;

namespace {

/// The end of 0.3 s with a flow that rises from nothing, p = 9 kPa at first.
double end_pressure(const Windkessel &arteries, double flow, int n_steps) {
  double p = 9000;
  for (int n = 1; n <= n_steps; ++n) {
    const auto [rest, slope] = arteries.answer(p, 0.3 / n_steps);
    p = rest + slope * flow * n / n_steps;
  }
  return p;
}

TEST(Windkessel, WithoutComplianceIsAConstantPressure) {
  const auto [rest, slope] = Windkessel{}.answer(9000, 1e-3);
  EXPECT_EQ(rest, 9000);
  EXPECT_EQ(slope, 0);
}

TEST(Windkessel, KeepsTheBlood) {
  const Windkessel arteries{1.5e-8, 1.2e8, 700};
  const double dt = 2e-4, flow = 3e-4, p_n = 9000;
  const auto [rest, slope] = arteries.answer(p_n, dt);
  const double p = rest + slope * flow, leaves = (p - arteries.venous_pressure) / arteries.peripheral_resistance;
  EXPECT_NEAR(arteries.compliance * (p - p_n), dt * (flow - leaves), 1e-12 * dt * flow);
}

/// C dp/dt + (p - p_v) / R = a t has the solution p_v + R a (t - RC) + (p_0 - p_v + R a RC) e^{-t/RC}.
TEST(Windkessel, ConvergesInFirstOrderToTheExactPressure) {
  const Windkessel arteries{1.5e-8, 1.2e8, 700};
  const double R = arteries.peripheral_resistance, RC = R * arteries.compliance, flow = 4e-4, a = flow / 0.3;
  const double exact = 700 + R * a * (0.3 - RC) + (9000 - 700 + R * a * RC) * std::exp(-0.3 / RC);
  const double coarse = end_pressure(arteries, flow, 100) - exact, fine = end_pressure(arteries, flow, 200) - exact;
  EXPECT_LT(std::abs(fine), 20);
  EXPECT_NEAR(coarse / fine, 2, 0.02);
}

} // namespace
