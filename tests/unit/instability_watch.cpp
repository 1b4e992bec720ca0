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

TEST(InstabilityWatch, AValveThatSwitchesIsNone) {
  EXPECT_EQ(alarm([](int n) { return n == 100 ? 5000. : n > 100 ? 40 + 5000 * std::pow(0.4, n - 100) : 40.; }), 0);
}

TEST(InstabilityWatch, TheFastestContractionIsNone) {
  EXPECT_EQ(alarm([](int n) { return 60 * std::min(1., n / 50.); }), 0);
}
