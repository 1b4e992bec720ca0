#include "mech_solver/active/rdq18_ann.h"

#include "common/base/failure.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace heartbus::mech;

namespace {

/// Evaluations of the published network by its authors' Python code: calcium [uM], sarcomere length [um], s0, s1,
/// rates.
constexpr double samples[][6] = {
    {0.9735944466161087, 1.934893356881935, 0.02458411436171681, -0.2900834186828825, -0.01271058341388276,
     19.16754238846217},
    {1.293236201051976, 1.816792787652732, 0.4377932678579664, -0.1946066276384646, -3.587183710929413,
     8.439389275031637},
    {0.9423084116478181, 1.991838777130942, 0.5983259614735266, 0.2885012032657381, 16.60015594240127,
     -7.022800786644038},
    {0.7544612703060942, 2.2447439171745, 0.5604261095737498, -0.08532288197455787, -12.51736947058215,
     7.347495243100362},
    {0.171822248194458, 2.216322073826699, 0.47225898449321, -0.1563783342042287, -17.79696113727476,
     6.348749193897857},
    {0.636600167741216, 1.899256522254628, 0.05445182737147314, 0.04819943159211038, 0.5304868436854804,
     0.3204290583863125},
    {0.6885468743378867, 2.277295246845369, 0.2999374882125882, -0.04486282509055467, -12.20249828469681,
     5.452839715832823},
    {0.6512509815657227, 2.167241785894364, 0.4266857267938499, 0.259235811968027, 15.13468837659202,
     -6.777295797528528},
    {0.265707817737122, 2.286314406911477, 0.5339613334323123, 0.1934242965258423, -1.236006720687067,
     -0.8689505930758541},
    {0.1087405312232302, 2.16600309782828, 0.368623948169398, -0.2829807809318873, -17.50452278913228,
     5.906234726794277},
    {0.5492494692659815, 2.015149365973917, 0.5796372484704421, 0.03733910533707419, -16.88324152572831,
     6.008493768528611},
    {1.224080625073528, 2.080237976003093, 0.1730527286587263, -0.05226219439146437, -11.65871648623174,
     6.135925784173613},
};

/// Calcium transient of the published demo: two exponentials above a resting level [s, uM].
double demo_calcium(double t) {
  const double c0 = 0.1, peak = 1.1, tau1 = 0.02, tau2 = 0.05, t0 = 0.01, r = tau1 / tau2;
  const double beta = std::pow(r, -1 / (r - 1)) - std::pow(r, -1 / (1 - 1 / r));
  return t < t0 ? c0 : c0 + (peak - c0) / beta * (std::exp((t0 - t) / tau1) - std::exp((t0 - t) / tau2));
}

/// Sarcomere length of the published demo: 5 % shorter between 0.15 and 0.55 s [um].
double demo_length(double t) {
  const double shortening = 1 - std::exp(std::min(0.0, (0.15 - t) / 0.05));
  const double recovery = 1 - std::exp(std::min(0.0, (0.55 - t) / 0.02));
  return 2.2 - 0.11 * (shortening - recovery);
}

double steady_state(double calcium, double length) {
  const Rdq18Ann model;
  std::vector<double> s = model.initial_state();
  for (unsigned i = 0; i < 100000; ++i)
    model.advance(1e-3, calcium, length, s.data());
  return model.permissivity(s.data());
}

} // namespace

TEST(Rdq18Ann, RatesAreThoseOfThePublishedNetwork) {
  const Rdq18Ann model;
  for (const auto &sample : samples) {
    double ds[2];
    model.rate(sample + 2, sample[0], sample[1], ds);
    EXPECT_NEAR(ds[0], sample[4], 1e-11);
    EXPECT_NEAR(ds[1], sample[5], 1e-11);
  }
}

TEST(Rdq18Ann, DemoTrajectoryPeaksWhereTheReferenceDoes) {
  const Rdq18Ann model;
  std::vector<double> s = model.initial_state();
  double peak = 0, peak_time = 0;
  const double dt = 2e-4;
  for (unsigned n = 0; n < 2500; ++n) { // inputs of the new time, as in the scheme
    model.advance(dt, demo_calcium((n + 1) * dt), demo_length((n + 1) * dt), s.data());
    if (s[0] > peak) {
      peak = s[0];
      peak_time = (n + 1) * dt;
    }
    if (n + 1 == 1000) {
      EXPECT_NEAR(s[0], 0.1726388784, 1e-8);
    }
  }
  EXPECT_NEAR(peak, 0.240686, 1e-6);
  EXPECT_NEAR(peak_time, 0.126, 1e-9);
  EXPECT_NEAR(s[0], 0.00184713556, 1e-8); // t = 0.5 s
}

TEST(Rdq18Ann, SteadyStatesFollowTheForceCalciumCurve) {
  EXPECT_NEAR(steady_state(0.1, 2.2), 0.0014927871, 1e-8);
  EXPECT_NEAR(steady_state(0.4, 2.2), 0.27362518, 1e-6);
  EXPECT_NEAR(steady_state(0.5, 2.2), 0.67816755, 1e-6);
  EXPECT_NEAR(steady_state(1.0, 2.2), 0.91364106, 1e-6);
  EXPECT_NEAR(steady_state(0.5, 2.0), 0.27996528, 1e-6);
}

TEST(Rdq18Ann, SarcomereLengthIsClampedToTheTrainedRange) {
  const Rdq18Ann model;
  const double s[2] = {0.2, 0.1};
  double inside[2], outside[2];
  model.rate(s, 0.5, 2.3, inside);
  model.rate(s, 0.5, 2.9, outside);
  EXPECT_EQ(inside[0], outside[0]);
  model.rate(s, 0.5, 1.7, inside);
  model.rate(s, 0.5, 1.2, outside);
  EXPECT_EQ(inside[1], outside[1]);
}

TEST(ActiveModel, UnknownNamesAreRefused) { EXPECT_THROW(make_active_model("rdq20"), heartbus::Failure); }
