#include "ep_solver/ionic/ttp06.h"
#include "common/base/failure.h"
#include "ep_solver/ionic/pacing.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace heartbus;

namespace {

ep::Beat beat(const std::string &name, int number, double cycle_length, double dt) {
  const auto model = ep::make_ionic_model(name);
  ep::CellState cell = model->initial_state("published");
  ep::Pacing pacing;
  pacing.cycle_length = cycle_length;
  pacing.dt = dt;
  for (int k = 1; k < number; ++k)
    ep::pace(*model, cell, pacing);
  return ep::pace(*model, cell, pacing);
}

/// A beat from the limit cycle, stimulated as tissue is.
ep::Beat beat_of_tissue(ep::Integrator integrator, double dt) {
  const auto model = ep::make_ionic_model("ttp06_epi");
  ep::CellState cell = model->initial_state("limit_cycle");
  return ep::pace(*model, cell, {0.8, dt, integrator, 35.714, 3e-3, false});
}

const std::string cells[] = {"ttp06_epi", "ttp06_endo", "ttp06_mid"};

} // namespace

/// Figures of an independent implementation of the equations with the same scheme, dt = 0.02 ms, every 800 ms.
TEST(TTP06, ThirdBeatIsThatOfAnIndependentImplementation) {
  struct {
    double v_diastole, v_max, duration, calcium_diastole, calcium_peak, peak_time;
  } const expected[] = {{-85.4448, 39.157, 305.34, 0.10815, 0.97900, 26.54},
                        {-85.9226, 39.029, 296.30, 0.11081, 1.0385, 28.34},
                        {-85.7894, 37.657, 384.16, 0.12215, 1.4817, 28.66}};
  for (int k = 0; k < 3; ++k) {
    const ep::Beat b = beat(cells[k], 3, 0.8, 2e-5);
    EXPECT_NEAR(1e3 * b.v_diastole, expected[k].v_diastole, 1e-4) << cells[k];
    EXPECT_NEAR(1e3 * b.v_max, expected[k].v_max, 1e-3) << cells[k];
    EXPECT_NEAR(1e3 * b.duration, expected[k].duration, 0.02) << cells[k]; // the reference does not interpolate
    EXPECT_NEAR(b.calcium_diastole, expected[k].calcium_diastole, 1e-5) << cells[k];
    EXPECT_NEAR(b.calcium_peak, expected[k].calcium_peak, 1e-4) << cells[k];
    EXPECT_NEAR(1e3 * b.calcium_peak_time, expected[k].peak_time, 0.02) << cells[k];
  }
}

/// The reference here is another scheme (Rush-Larsen for the gates, all else explicit), extrapolated to dt = 0 from
/// 0.005 and 0.0025 ms; first beat. Ours is extrapolated from 0.02 and 0.01 ms, where its own error is about 0.25 mV,
/// 0.01 ms and 6e-4 uM; what remains after extrapolation is a tenth of that.
TEST(TTP06, SchemeConvergesToTheSameBeatAsRushLarsen) {
  struct {
    double v_max, duration, calcium_peak;
  } const expected[] = {{37.206, 290.30, 0.96193}, {37.148, 282.01, 1.0152}, {34.622, 351.46, 1.4578}};
  for (int k = 0; k < 3; ++k) {
    const ep::Beat coarse = beat(cells[k], 1, 1, 2e-5), fine = beat(cells[k], 1, 1, 1e-5);
    EXPECT_NEAR(1e3 * (2 * fine.v_max - coarse.v_max), expected[k].v_max, 0.03) << cells[k];
    EXPECT_NEAR(1e3 * (2 * fine.duration - coarse.duration), expected[k].duration, 0.05) << cells[k];
    EXPECT_NEAR(2 * fine.calcium_peak - coarse.calcium_peak, expected[k].calcium_peak, 2e-4) << cells[k];
  }
}

/// First order, then second, by the errors against a step of 0.003 ms, whose own is a twentieth of the smallest.
TEST(TTP06, OrderOfTheIntegrators) {
  using ep::Integrator;
  const ep::Beat exact = beat_of_tissue(Integrator::exponential_midpoint, 3.125e-6);
  const auto order = [&](Integrator integrator, double ep::Beat::*figure) {
    const double coarse = beat_of_tissue(integrator, 2.5e-5).*figure - exact.*figure,
                 fine = beat_of_tissue(integrator, 1.25e-5).*figure - exact.*figure;
    return std::log2(std::abs(coarse / fine));
  };
  for (const auto figure : {&ep::Beat::duration, &ep::Beat::calcium_peak}) {
    EXPECT_NEAR(order(Integrator::imex_euler, figure), 1, 0.15);
    EXPECT_NEAR(order(Integrator::exponential_midpoint, figure), 2, 0.25);
  }
}

/// At 0.2 ms; the paper's scheme: 1.6 %.
TEST(TTP06, CalciumOfTheMidpointRuleIsRightToAThousandth) {
  const ep::Beat exact = beat_of_tissue(ep::Integrator::exponential_midpoint, 1.25e-5),
                 beat = beat_of_tissue(ep::Integrator::exponential_midpoint, 2e-4),
                 euler = beat_of_tissue(ep::Integrator::imex_euler, 2e-4);
  EXPECT_NEAR(beat.calcium_peak / exact.calcium_peak, 1, 5e-4);
  EXPECT_NEAR(euler.calcium_peak / exact.calcium_peak, 0.984, 2e-3);
  EXPECT_NEAR(1e3 * beat.duration, 1e3 * exact.duration, 1.5);
}

TEST(TTP06, DecayIsPositiveFallsAndIsNearlyTheExponential) {
  double last = 1;
  for (double s = 1e-3; s < 1e4; s *= 1.5) {
    EXPECT_LT(ep::decay(s), last);
    EXPECT_GT(ep::decay(s), 0);
    EXPECT_NEAR(ep::decay(s), std::exp(-s), std::pow(s, 5) / 120 + 1e-15);
    last = ep::decay(s);
  }
}

TEST(TTP06, LimitCycleReturnsAfterOneBeat) {
  for (const std::string &name : cells) {
    const auto model = ep::make_ionic_model(name);
    const ep::CellState start = model->initial_state("limit_cycle");
    ep::CellState cell = start;
    ep::pace(*model, cell, {});
    EXPECT_NEAR(cell.v, start.v, 1e-6) << name;
    for (unsigned s = 0; s < model->n_states(); ++s)
      EXPECT_NEAR(cell.states[s] / start.states[s], 1, 2e-4) << name << ", state " << s;
  }
}

TEST(TTP06, CurrentVanishesAtRest) {
  for (const std::string &name : cells) {
    const auto model = ep::make_ionic_model(name);
    ep::CellState cell = model->initial_state("limit_cycle");
    EXPECT_LT(std::abs(model->step_cell(ep::Integrator::imex_euler, cell.v, cell.states, 2e-5, 0)), 0.05)
        << name; // V/s; the upstroke has 350
  }
}

TEST(TTP06, CalciumCurrentIsSmoothThroughItsRemovableSingularity) {
  using namespace ep::ttp06;
  EXPECT_EQ(bernoulli(0.0, 1.0), 1.0);
  for (const double x : {1e-9, 1e-3, 0.1, 0.29999, 0.30001, 2.0})
    for (const double signed_x : {x, -x})
      EXPECT_NEAR(bernoulli(signed_x, std::exp(signed_x)), signed_x / std::expm1(signed_x), 2e-15) << signed_x;
  const auto row = ep::make_ionic_model("ttp06_epi")->initial_state("published").states;
  States<double> y;
  std::copy(row.begin(), row.end(), y.begin());
  const double below = currents(epi, 15 - 1e-4, y).CaL, at = currents(epi, 15.0, y).CaL,
               above = currents(epi, 15 + 1e-4, y).CaL;
  EXPECT_NEAR(at, 0.5 * (below + above), 1e-9 * std::abs(at));
}

/// Also in the last, incomplete block, and from potentials on both sides of every switch.
TEST(TTP06, ManyNodesAtOnceAgreeWithTheSingleCell) {
  const unsigned n_nodes = 27;
  for (const auto integrator : {ep::Integrator::imex_euler, ep::Integrator::exponential_midpoint})
    for (const std::string &name : cells) {
      const auto model = ep::make_ionic_model(name);
      const ep::CellState start = model->initial_state("published");
      auto states = model->uniform_states(n_nodes, start.states);
      std::vector<double> v(n_nodes), i_ion(n_nodes), error(n_nodes), calcium(n_nodes);
      for (unsigned node = 0; node < n_nodes; ++node)
        v[node] = -0.1 + 0.005 * node; // -100 to 30 mV, -40 and 15 mV among them
      for (int n = 0; n < 3; ++n)
        model->step(integrator, n_nodes, v.data(), states.data(), states.data(), 2e-4, i_ion.data(), error.data());
      model->get_calcium(n_nodes, states, calcium.data());
      for (unsigned node = 0; node < n_nodes; ++node) {
        ep::CellState cell = start;
        double expected = 0;
        for (int n = 0; n < 3; ++n)
          expected = model->step_cell(integrator, v[node], cell.states, 2e-4, 0);
        EXPECT_NEAR(i_ion[node], expected, 1e-12 * (1 + std::abs(expected))) << name << " at " << v[node] << " V";
        EXPECT_NEAR(calcium[node], 1e3 * cell.states[model->calcium_state()], 1e-12) << name;
      }
    }
}

/// The estimate is the difference of subspace calcium from its extrapolation, over 1 mM.
TEST(TTP06, StepReportsItsDifferenceFromExtrapolation) {
  using ep::ttp06::Ca_ss;
  const unsigned n_nodes = 9, rate = Ca_ss + ep::ttp06::n_concentrations;
  const auto model = ep::make_ionic_model("ttp06_epi");
  std::vector<double> v(n_nodes, -0.085), i_ion(n_nodes), error(n_nodes);
  v[6] = 0.01;
  auto states = model->uniform_states(n_nodes, model->initial_state("published").states);
  const auto value = [&](unsigned s) { return states[6 / fem::n_lanes * model->n_kept() + s][6 % fem::n_lanes]; };
  for (int n = 0; n < 5; ++n) {
    const double extrapolated = value(Ca_ss) + 0.2 * value(rate);
    model->step(ep::Integrator::exponential_midpoint, n_nodes, v.data(), states.data(), states.data(), 2e-4,
                i_ion.data(), error.data());
    EXPECT_NEAR(error[6], std::abs(value(Ca_ss) - extrapolated), 1e-12);
    EXPECT_GT(error[6], 1e-6);
    EXPECT_LT(error[5], 0.1 * error[6]);
  }
}

TEST(TTP06, UnknownNameIsRefusedWithTheKnownOnes) {
  try {
    ep::make_ionic_model("ttp60_epi");
    FAIL();
  } catch (const Failure &failure) {
    EXPECT_EQ(failure.code(), ExitCode::scene);
    EXPECT_NE(std::string(failure.what()).find("ttp06_endo"), std::string::npos);
  }
}
