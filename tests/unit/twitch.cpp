#include "mech_solver/active/twitch.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace heartbus::mech;

namespace {

/// A published calcium transient [s, uM]: two exponentials above a resting level (as in tests/unit/rdq18_ann.cpp).
double transient(double t) {
  const double r = 0.02 / 0.05, beta = std::pow(r, -1 / (r - 1)) - std::pow(r, -1 / (1 - 1 / r));
  return t < 0.01 ? 0.1 : 0.1 + (std::exp((0.01 - t) / 0.02) - std::exp((0.01 - t) / 0.05)) / beta;
}

struct Course {
  double peak = 0, peak_time = 0, at_200_ms = 0, at_500_ms = 0;
};

Course course(int steps) {
  const Twitch model;
  std::vector<double> s = model.initial_state();
  Course found;
  for (int n = 1; n <= steps; ++n) {
    const double t = 0.5 * n / steps;
    model.advance(0.5 / steps, transient(t), 2.2, s.data());
    if (s[0] > found.peak) {
      found.peak = s[0];
      found.peak_time = t;
    }
    (5 * n == 2 * steps ? found.at_200_ms : found.at_500_ms) = s[0];
  }
  return found;
}

} // namespace

TEST(Twitch, SteadyForceIsHillsCurveWhateverTheLength) {
  for (const auto &[calcium, force] : {std::pair{0.6, 1. / 9}, {1.2, 0.5}, {2.4, 8. / 9}})
    for (const double length : {1.5, 2.2}) {
      const Twitch model;
      double s = 0.3, rate;
      model.advance(10, calcium, length, &s);
      EXPECT_NEAR(s, force, 1e-14);
      model.rate(&s, calcium, length, &rate);
      EXPECT_NEAR(rate, 0, 1e-12);
      EXPECT_FALSE(model.clamps(length));
    }
  EXPECT_NEAR(Twitch().initial_state()[0], 1. / 1729, 1e-15); // 12^3 + 1
}

/// ds/dt = (h - s)/tau from s0: s = h + (s0 - h) e^{-t/tau}, with steps of any length.
TEST(Twitch, UnderConstantCalciumItIsExact) {
  const Twitch model;
  for (const double dt : {1e-4, 0.01, 0.1}) {
    double s = 0.9;
    for (int n = 0; n < std::lround(0.1 / dt); ++n)
      model.advance(dt, 1.2, 2.2, &s);
    EXPECT_NEAR(s, 0.5 + 0.4 * std::exp(-1), 1e-12);
  }
}

/// Against the solution's integral, s(t) = e^{-t/tau} (s0 + int h(Ca(r))/tau e^{r/tau} dr), by Gauss quadrature.
TEST(Twitch, UnderATransientItConvergesToTheIntegralWithFirstOrder) {
  const Course coarse = course(500), fine = course(5000);
  EXPECT_NEAR(fine.peak, 0.16018204, 2e-5);
  EXPECT_NEAR(fine.peak_time, 0.0872, 3e-4);
  EXPECT_NEAR(fine.at_200_ms, 0.06898346, 1e-4);
  EXPECT_NEAR(fine.at_500_ms, 0.00405568, 1e-5);
  EXPECT_NEAR((coarse.at_200_ms - 0.06898346) / (fine.at_200_ms - 0.06898346), 10, 0.5);
}
