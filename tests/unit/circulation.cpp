#include "cavity_solver/circulation.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace heartbus::cavity;

namespace {

constexpr double dt = 1e-3, mL = 1e-6;

CirculationParameters windkessel() {
  CirculationParameters parameters;
  parameters.arteries.compliance = 1.5e-8;
  parameters.arteries.peripheral_resistance = 1.2e8;
  return parameters;
}

/// A ventricle whose volume is v0 + c p.
CavityAnswer answer(double v0, double c, double at) { return {v0 + c * at, c, at}; }

} // namespace

TEST(Circulation, ClosedValvesKeepTheVolume) {
  Circulation circulation({});
  const double p = circulation.solve(answer(100 * mL, 1e-9, 3000), 104 * mL, dt);
  EXPECT_NEAR(p, 4000, 1e-6);
  EXPECT_EQ(circulation.mitral_flow(), 0);
  EXPECT_EQ(circulation.aortic_flow(), 0);
}

TEST(Circulation, WhatFlowsIsWhatTheVolumeChangesBy) {
  for (const double old : {90 * mL, 104 * mL, 140 * mL}) { // filling, closed, ejection
    Circulation circulation(windkessel());
    const double p = circulation.solve(answer(100 * mL, 1e-9, 3000), old, dt);
    const double volume = 100 * mL + 1e-9 * p;
    EXPECT_NEAR(volume - old, dt * (circulation.mitral_flow() - circulation.aortic_flow()), 1e-18);
    EXPECT_FALSE(circulation.mitral_open() && circulation.aortic_open());
  }
}

TEST(Circulation, AValveThatOpensPassesBloodOneWay) {
  Circulation circulation({});
  const double filling = circulation.solve(answer(100 * mL, 1e-9, 1000), 101 * mL, dt);
  EXPECT_LT(filling, 1333);
  EXPECT_NEAR(circulation.mitral_flow(), (1333 - filling) / 1e6, 1e-12);
  const double ejection = circulation.solve(answer(100 * mL, 1e-9, 10000), 110 * mL, dt);
  EXPECT_GT(ejection, 9000);
  EXPECT_NEAR(circulation.aortic_flow(), (ejection - 9000) / 1.3e7, 1e-12);
}

TEST(Circulation, ArteriesRunEmptyExponentiallyInDiastole) {
  Circulation circulation(windkessel());
  constexpr double end = 0.5;
  for (int step = 0; step < std::lround(end / dt); ++step) {
    circulation.solve(answer(100 * mL, 1e-9, 3000), 103 * mL, dt);
    circulation.commit();
  }
  // p = p_0 exp(-t / (R C)); implicit Euler is of first order
  const double exact = 9000 * std::exp(-end / (1.2e8 * 1.5e-8));
  EXPECT_NEAR(circulation.arterial_pressure() / exact, 1, 2e-4);
}

TEST(Circulation, TheAnswerDoesNotDependOnTheGuess) {
  for (const double old : {90 * mL, 104 * mL, 140 * mL}) {
    Circulation one(windkessel()), other(windkessel());
    EXPECT_NEAR(one.solve(answer(100 * mL, 1e-9, 0), old, dt), other.solve(answer(100 * mL, 1e-9, 20000), old, dt),
                1e-6);
  }
}

/// A jet of area A costs rho/2 (Q / A)^2; the blood lost is that of the volume, to rounding.
TEST(Circulation, JetsCostTheirKineticEnergy) {
  CirculationParameters parameters = windkessel();
  parameters.aortic_area = 2.5e-4;
  parameters.mitral_area = 3e-4;
  for (const double old : {90 * mL, 104 * mL, 140 * mL}) { // filling, closed, ejection
    Circulation circulation(parameters);
    const double p = circulation.solve(answer(100 * mL, 1e-9, 3000), old, dt);
    const double in = circulation.mitral_flow(), out = circulation.aortic_flow();
    EXPECT_NEAR(100 * mL + 1e-9 * p - old, dt * (in - out), 1e-18);
    const double loss_in = 1e6 * in + 530 * std::pow(in / 3e-4, 2),
                 loss_out = 1.3e7 * out + 530 * std::pow(out / 2.5e-4, 2);
    EXPECT_NEAR(std::max(1333 - p, 0.), loss_in, 1e-9 * std::abs(p));
    EXPECT_NEAR(std::max(p - circulation.arterial_pressure(), 0.), loss_out, 1e-9 * std::abs(p));
  }
}
