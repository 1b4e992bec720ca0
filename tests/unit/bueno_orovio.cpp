#include "ep_solver/ionic/bueno_orovio.h"
#include "ep_solver/ionic/pacing.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace heartbus;
using ep::Integrator;

namespace {

const std::string cells[] = {"bueno_orovio_epi", "bueno_orovio_endo", "bueno_orovio_mid"};

/// The first beat from the published state, every 800 ms.
ep::Trace first_beat(const std::string &name, Integrator integrator, double dt) {
  const auto model = ep::make_ionic_model(name);
  ep::CellState cell = model->initial_state("published");
  return ep::trace(*model, cell, {0.8, dt, integrator, 52, 1e-3, false});
}

ep::Beat beat(const std::string &name, const std::string &start, Integrator integrator, double dt,
              double cycle_length = 0.8, int number = 1) {
  const auto model = ep::make_ionic_model(name);
  ep::CellState cell = model->initial_state(start);
  const ep::Pacing pacing{cycle_length, dt, integrator, 52, 1e-3, false};
  for (int k = 1; k < number; ++k)
    ep::pace(*model, cell, pacing);
  return ep::pace(*model, cell, pacing);
}

} // namespace

/// Figures of an independent integration of the equations, by the explicit midpoint rule with 0.004 ms. Both miss the
/// instants of the model's switches by a part of their step.
TEST(BuenoOrovio, FirstBeatIsThatOfAnIndependentImplementation) {
  struct {
    double v_max, duration, calcium_peak, peak_time;
  } const expected[] = {
      {41.729, 272.50, 1.16755, 43.47}, {45.319, 277.12, 1.12742, 34.96}, {49.664, 459.56, 1.73947, 36.82}};
  for (int k = 0; k < 3; ++k) {
    const ep::Beat b = beat(cells[k], "published", Integrator::exponential_midpoint, 1e-5);
    EXPECT_NEAR(1e3 * b.v_diastole, -84, 1e-9) << cells[k];
    EXPECT_NEAR(1e3 * b.v_max, expected[k].v_max, 0.03) << cells[k];
    EXPECT_NEAR(1e3 * b.duration, expected[k].duration, 0.1) << cells[k];
    EXPECT_NEAR(b.calcium_peak / expected[k].calcium_peak, 1, 1e-3) << cells[k];
    EXPECT_NEAR(1e3 * b.calcium_peak_time, expected[k].peak_time, 0.1) << cells[k];
  }
}

/// By the whole course of the potential, against a step of 0.0025 ms: in single figures the model's switches, anywhere
/// within a step, hide the order.
TEST(BuenoOrovio, MidpointRuleIsOfSecondOrderAndEulerOfFirst) {
  const ep::Trace exact = first_beat("bueno_orovio_epi", Integrator::exponential_midpoint, 2.5e-6);
  const auto error = [&](Integrator integrator, double dt) {
    const ep::Trace beat = first_beat("bueno_orovio_epi", integrator, dt);
    const std::size_t ratio = std::lround(dt / exact.dt);
    double sum = 0;
    for (std::size_t n = 0; n < beat.v.size(); ++n)
      sum += dt * std::pow(beat.v[n] - exact.v[ratio * n], 2);
    return std::sqrt(sum);
  };
  const auto order = [&](Integrator integrator, double dt) {
    return std::log2(error(integrator, dt) / error(integrator, dt / 4)) / 2;
  };
  EXPECT_NEAR(order(Integrator::imex_euler, 4e-5), 1, 0.2);
  EXPECT_GT(order(Integrator::exponential_midpoint, 8e-5), 1.8);
}

TEST(BuenoOrovio, ActionPotentialsShortenWithTheCycle) {
  for (const std::string &name : cells) {
    double last = 0;
    for (const double cycle : {0.4, 0.5, 0.6, 0.8, 1.0}) {
      const double duration = beat(name, "limit_cycle", Integrator::exponential_midpoint, 5e-5, cycle, 10).duration;
      EXPECT_GT(duration, last) << name << ", every " << cycle << " s";
      last = duration;
    }
  }
}

/// The surrogate's diastolic and peak values are those of the model of ten Tusscher and Panfilov, cell by cell.
TEST(BuenoOrovio, CalciumHasTheRangeOfThatOfTTP06) {
  for (const std::string type : {"epi", "endo", "mid"}) {
    const ep::Beat ours = beat("bueno_orovio_" + type, "limit_cycle", Integrator::exponential_midpoint, 2e-5),
                   theirs = beat("ttp06_" + type, "limit_cycle", Integrator::exponential_midpoint, 2e-5);
    EXPECT_NEAR(ours.calcium_diastole / theirs.calcium_diastole, 1, 5e-3) << type;
    EXPECT_NEAR(ours.calcium_peak / theirs.calcium_peak, 1, 5e-3) << type;
    EXPECT_NEAR(1e3 * ours.calcium_peak_time, 1e3 * theirs.calcium_peak_time, 20) << type;
  }
}

TEST(BuenoOrovio, LimitCycleReturnsAfterOneBeat) {
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

TEST(BuenoOrovio, RestIsAStateOfEquilibrium) {
  for (const std::string &name : cells) {
    const auto model = ep::make_ionic_model(name);
    for (const auto integrator : {Integrator::imex_euler, Integrator::exponential_midpoint}) {
      ep::CellState cell = model->initial_state("published");
      EXPECT_NEAR(model->step_cell(integrator, cell.v, cell.states, 1e-4, 0), 0, 1e-10) << name;
      EXPECT_EQ(cell.states[ep::bueno_orovio::v], 1) << name;
      EXPECT_EQ(cell.states[ep::bueno_orovio::w], 1) << name;
    }
  }
}

/// Also in the last, incomplete block, and from potentials on both sides of every switch.
TEST(BuenoOrovio, ManyNodesAtOnceAgreeWithTheSingleCell) {
  const unsigned n_nodes = 31;
  for (const auto integrator : {Integrator::imex_euler, Integrator::exponential_midpoint})
    for (const std::string &name : cells) {
      const auto model = ep::make_ionic_model(name);
      const ep::CellState start = model->initial_state("limit_cycle");
      auto states = model->uniform_states(n_nodes, start.states);
      std::vector<double> v(n_nodes), i_ion(n_nodes), error(n_nodes), calcium(n_nodes);
      for (unsigned node = 0; node < n_nodes; ++node)
        v[node] = -0.0843 + (node < 5 ? 3e-4 : 4.5e-3) * node; // -84.3 to 50.7 mV
      for (int n = 0; n < 3; ++n)
        model->step(integrator, n_nodes, v.data(), states.data(), states.data(), 2e-4, i_ion.data(), error.data());
      model->get_calcium(n_nodes, states, calcium.data());
      for (unsigned node = 0; node < n_nodes; ++node) {
        ep::CellState cell = start;
        double expected = 0;
        for (int n = 0; n < 3; ++n)
          expected = model->step_cell(integrator, v[node], cell.states, 2e-4, 0);
        EXPECT_NEAR(i_ion[node], expected, 1e-12 * (1 + std::abs(expected))) << name << " at " << v[node] << " V";
        EXPECT_NEAR(calcium[node], cell.states[model->calcium_state()], 1e-12) << name;
      }
    }
}

/// The estimate is the difference of the fast gate from its extrapolation: none at rest, large when the gate begins to
/// close.
TEST(BuenoOrovio, StepReportsItsDifferenceFromExtrapolation) {
  const auto model = ep::make_ionic_model("bueno_orovio_epi");
  auto states = model->uniform_states(2, model->initial_state("published").states);
  double v[2] = {-0.084, 0}, i_ion[2], error[2];
  model->step(Integrator::exponential_midpoint, 2, v, states.data(), states.data(), 2e-4, i_ion, error);
  const double closed = -std::expm1(-0.2 / ep::bueno_orovio::tau_v_plus), scale = ep::bueno_orovio::error_scale;
  EXPECT_NEAR(error[0], 0, 1e-15);
  EXPECT_NEAR(error[1], scale * closed, 1e-6);
  model->step(Integrator::exponential_midpoint, 2, v, states.data(), states.data(), 2e-4, i_ion, error);
  EXPECT_NEAR(error[1], scale * closed * closed, 1e-6);
}
