#include "common/interface/instability_watch.h"
#include "fluid_solver/models/inflow_watch.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace heartbus::fluid;
using namespace heartbus::interface;

namespace {

/// The step at which an alarm comes, or 0.
template <class Signal>
int alarm(const Signal &kinematic_jump, int n_steps = 1000) {
  InstabilityWatch watch(2e-4);
  for (int n = 1; n <= n_steps; ++n)
    if (watch.add(kinematic_jump(n)))
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

TEST(InstabilityWatch, MotionsThatTurnRoundAndGrowAreRecognisedBeforeTheyCrushAWall) {
  const double dt = 0.8e-3, pressure = 1000;
  const auto alarm_at = [&](double growth, double cosine) {
    InstabilityWatch watch(dt);
    for (double jump = 1; jump < 1e4; jump *= growth)
      if (watch.add(jump, jump / pressure, false, cosine))
        return jump;
    return 0.;
  };
  EXPECT_LT(alarm_at(1.2, -0.9), 300) << "the wall is crushed at 1300 Pa";
  EXPECT_GT(alarm_at(1.2, -0.9), 80);
  EXPECT_EQ(alarm_at(1.2, 0.9), 0) << "what does not turn round may be a load";
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

namespace {

/// A runaway of x_n = factor^n Pa, seen until the alarm.
std::string told(double factor, Runaway seen) {
  InstabilityWatch watch(2e-4);
  double x = 1, before = 0;
  do {
    before = x;
    x *= factor;
  } while (!watch.add(std::abs(x), 0.1, false, x * before > 0 ? 1 : -1));
  seen.kinematic_jump = std::abs(x);
  seen.alternates = watch.alternates();
  return explanation(seen, 0);
}

bool says(const std::string &text, const std::string &words) { return text.find(words) != std::string::npos; }

Runaway alpha(double value, double limit) {
  Runaway seen;
  seen.alpha = value;
  seen.alpha_limit = limit;
  return seen;
}

} // namespace

TEST(InstabilityWatch, KnowsADisagreementThatAlternatesFromOneThatDoesNot) {
  InstabilityWatch alternating(2e-4), monotone(2e-4), single(2e-4);
  for (int n = 0; n < 10; ++n) {
    alternating.add(100, 0, false, -0.9);
    monotone.add(100, 0, false, 0.99);
    single.add(100, 0, false, n == 7 ? -1 : 0.9);
  }
  EXPECT_TRUE(alternating.alternates());
  EXPECT_FALSE(monotone.alternates());
  EXPECT_FALSE(single.alternates());
}

TEST(Explanation, BlamesAlphaWhereTheSignChanges) {
  const std::string text = told(-1.5, alpha(15000, 23531));
  EXPECT_TRUE(says(text, "the coupling is unstable") && says(text, "with changing sign")) << text;
  EXPECT_TRUE(says(text, "write 'alpha: 7500 kg/(m^2 s)' or 'alpha: auto'")) << text;
}

TEST(Explanation, DoesNotBlameAlphaFarBelowTheLimitWhateverTheSign) {
  for (const double factor : {-1.5, 1.5}) {
    const std::string text = told(factor, alpha(5000, 23531));
    EXPECT_TRUE(says(text, "far below the limit of 23531")) << text;
    EXPECT_TRUE(says(text, "it is not alpha") && says(text, "tension")) << text;
    EXPECT_EQ(says(text, "with changing sign"), factor < 0) << text;
    EXPECT_FALSE(says(text, "unstable") || says(text, "alpha: ")) << text;
  }
}

TEST(Explanation, BlamesAlphaWhereItIsAboveTheLimit) {
  const std::string text = told(1.5, alpha(30000, 20000));
  EXPECT_TRUE(says(text, "wall and blood allow 20000: write 'alpha: 15000 kg/(m^2 s)' or 'alpha: auto'")) << text;
}

TEST(Explanation, DoesNotBlameAlphaBelowTheLimitWithoutChangeOfSign) {
  const std::string text = told(1.5, alpha(15000, 23531));
  EXPECT_TRUE(says(text, "coupling.alpha is 15000 kg/(m^2 s), below the limit of 23531")) << text;
  EXPECT_TRUE(says(text, "it is not alpha")) << text;
  EXPECT_FALSE(says(text, "unstable")) << text;
  EXPECT_FALSE(says(text, "alpha: ")) << text;
}

TEST(Explanation, DoubtsTheLimitOfIterationsAndOneThatIsNotKnown) {
  Runaway iterated = alpha(15000, 20000);
  iterated.iterates = true;
  EXPECT_TRUE(says(told(1.5, iterated), "the coupling may be unstable"));
  iterated.alpha = 5000;
  EXPECT_TRUE(says(told(1.5, iterated), "it is not alpha"));
  EXPECT_TRUE(says(told(1.5, alpha(5000, 0)), "its limit has not been estimated"));
}

TEST(InflowWatch, KnowsARunawayFromTheFastestFilling) {
  InflowWatch watch;
  const double filling[][2] = {{24, 0}, {350, 15}, {490, 100}, {600, 580}, {560, 1250}, {9, 1}}; // M0: 354 mL/s
  for (const auto &[push, energy] : filling) {
    watch.add(push);
    EXPECT_FALSE(watch.is_suspect(energy));
  }
  EXPECT_EQ(watch.push(), 600);
  EXPECT_FALSE(watch.is_runaway(21e3)) << "1460 mL/s, with which a run can end";
  EXPECT_TRUE(watch.is_suspect(21e3));
  EXPECT_TRUE(watch.is_runaway(98e3)) << "3160 mL/s, where EFS1 with backflow 0 was lost";
  watch.reset();
  EXPECT_FALSE(watch.is_suspect(900)) << "hardly pushed at all, hardly fast";
}

TEST(InflowWatch, TellsOrificeFlowEnergyAndTheKeyToChange) {
  const Inflow inflow{3.16e-3, 316.};
  EXPECT_NEAR(inflow.energy(), 1e5, 1e-6);
  const std::string text = explanation("mitral", inflow, 600, 0);
  for (const char *words : {"'mitral'", "3160 mL/s", "316 W", "100000 Pa per volume", "600 Pa", "'fluid.backflow: 1'"})
    EXPECT_TRUE(says(text, words)) << text;
  EXPECT_FALSE(says(explanation("mitral", inflow, 600, 1), "write"));
}
