#include "ep_solver/ionic/transient.h"

#include "common/base/failure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

using namespace heartbus;

namespace {

std::string complaint(const std::function<void()> &action) {
  try {
    action();
  } catch (const Failure &failure) {
    EXPECT_EQ(failure.code(), ExitCode::scene);
    return failure.what();
  }
  return "";
}

} // namespace

TEST(Transient, IsTheBeatOfAPacedCellSinceItsActivation) {
  for (const std::string name : {"ttp06_epi", "bueno_orovio_epi"}) {
    const auto model = ep::make_ionic_model(name);
    const ep::Transient transient(*model, "limit_cycle", 0.8);
    EXPECT_NEAR(transient.potential(0), 0, 2e-3) << name;
    EXPECT_LT(transient.potential(-1e-3), -0.03) << name;
    EXPECT_GT(transient.potential(1e-3), 0.01) << name;
    EXPECT_NEAR(transient.potential(transient.repolarisation()), -70e-3, 1e-5) << name;
    ep::CellState cell = model->initial_state("limit_cycle");
    const ep::Trace beat = ep::trace(*model, cell, {0.8, 1e-5, ep::Integrator::exponential_midpoint});
    const double start = beat.crossing(0, 0);
    for (const double phase : {5e-3, 0.03, 0.1, 0.3, 0.6}) {
      const std::size_t n = (start + phase) / beat.dt;
      EXPECT_NEAR(transient.calcium(phase), beat.calcium[n], 5e-3 * beat.calcium[n]) << name << " at " << phase;
    }
  }
}

TEST(Transient, RepeatsItselfWithEachPeriod) {
  for (const auto &[name, period] : {std::pair("ttp06_epi", 0.8), {"bueno_orovio_mid", 0.5}}) {
    const auto model = ep::make_ionic_model(name);
    const ep::Transient transient(*model, "limit_cycle", period);
    for (double phase = -0.1; phase < period; phase += 0.013) {
      EXPECT_NEAR(transient.calcium(phase), transient.calcium(phase + 3 * period), 1e-10);
      EXPECT_NEAR(transient.calcium(phase), transient.calcium(phase + 1e-5), 2e-3); // no jump where beats meet
    }
    EXPECT_EQ(transient.calcium(std::nan("")), transient.calcium(std::nan("")));
  }
}

/// A cell that is paced faster has other ions, hence another transient.
TEST(Transient, IsOfTheLimitCycleOfItsPeriod) {
  const auto model = ep::make_ionic_model("bueno_orovio_epi");
  const ep::Transient slow(*model, "limit_cycle", 0.8), fast(*model, "limit_cycle", 0.4);
  ep::CellState cell = model->initial_state("published");
  ep::Beat beat{};
  for (int k = 0; k < 40; ++k)
    beat = ep::pace(*model, cell, {0.4, 5e-5, ep::Integrator::exponential_midpoint});
  EXPECT_LT(fast.repolarisation(), slow.repolarisation() - 10e-3);
  double peak = 0;
  for (double phase = 0; phase < 0.1; phase += 1e-4)
    peak = std::max(peak, fast.calcium(phase));
  EXPECT_NEAR(peak, beat.calcium_peak, 2e-3);
}

TEST(Transient, WhatActivatesNoCellIsRefused) {
  const auto model = ep::make_ionic_model("ttp06_epi");
  EXPECT_NEAR(ep::latency(*model, "limit_cycle", 35.714, 3e-3), 1.2e-3, 0.8e-3);
  EXPECT_NE(complaint([&] { ep::latency(*model, "limit_cycle", 1, 3e-3); }).find("stimulus activates no cell"),
            std::string::npos);
  EXPECT_NE(complaint([&] { ep::Transient(*model, "limit_cycle", 0.02); }).find("stimulus.period"), std::string::npos);
}
