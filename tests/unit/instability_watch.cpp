#include "fluid_solver/instability_watch.h"

#include <cmath>
#include <gtest/gtest.h>

using heartbus::fluid::InstabilityWatch;

namespace {

/// The step at which an alarm comes, or 0.
template <class Signal>
int alarm(const Signal &disagreement, int n_steps = 1000) {
  InstabilityWatch watch(2e-4);
  for (int n = 1; n <= n_steps; ++n)
    if (watch.add(disagreement(n)))
      return n;
  return 0;
}

} // namespace

TEST(InstabilityWatch, GrowthFromRoundOffIsRecognisedWhenItMatters) {
  const int n = alarm([](int n) { return 1e-10 * std::pow(1.5, n); });
  const int matters = static_cast<int>(std::ceil(std::log(200 / 1e-10) / std::log(1.5)));
  EXPECT_GE(n, matters);
  EXPECT_LE(n, matters + 6);
}

TEST(InstabilityWatch, SlowGrowthIsRecognisedAtTenTimesThat) {
  const int n = alarm([](int n) { return std::pow(1.01, n); }, 2000);
  EXPECT_NEAR(n, std::log(2000) / std::log(1.01), 8);
}

TEST(InstabilityWatch, AStepThatAsksForManyTimesTheDatumIsRecognisedAtOnce) {
  InstabilityWatch watch(2e-4);
  EXPECT_FALSE(watch.add(1000, 75)); // too little to matter
  EXPECT_FALSE(watch.add(5000, 1));
  EXPECT_TRUE(watch.add(5000, 75));
}

TEST(InstabilityWatch, OfDirichletNeumannOnlyChangesLargerThanTheDatumCount) {
  InstabilityWatch steady(2e-4), growing(2e-4), slowly_growing(2e-4);
  bool alarm = false, slow_alarm = false;
  for (int n = 0; n < 12; ++n) {
    EXPECT_FALSE(steady.add(n < 6 ? 1e5 : 1e6, 0.5, true)); // a load that sets in
    alarm = growing.add(1e6 * std::pow(1.5, n), 2.5, true) || alarm;
    slow_alarm = slowly_growing.add(1e6 * std::pow(1.1, n), n < 5 ? 0.5 : 2.1, true) || slow_alarm;
  }
  EXPECT_TRUE(alarm);
  EXPECT_TRUE(slow_alarm);
}

TEST(InstabilityWatch, AValveThatSwitchesIsNone) {
  EXPECT_EQ(alarm([](int n) { return n == 100 ? 5000. : n > 100 ? 40 + 5000 * std::pow(0.4, n - 100) : 40.; }), 0);
}

TEST(InstabilityWatch, TheFastestContractionIsNone) {
  EXPECT_EQ(alarm([](int n) { return 60 * std::min(1., n / 50.); }), 0);
}
