#include "ep_solver/conductivity.h"
#include "ep_solver/ep_solver.h"
#include "ep_solver/ionic/ttp06.h"
#include "tests/benchmarks/heart.h"
#include "tests/benchmarks/limits.h"

namespace heartbus::benchmarks {

namespace {

/// A number that counts what is done with it.
struct Counted {
  double value = 0;
  Counted(double x = 0) : value(x) {}
  static inline double flops = 0;
};
#define COUNTED_OPERATOR(op)                                                                                           \
  Counted operator op(const Counted &a, const Counted &b) {                                                            \
    ++Counted::flops;                                                                                                  \
    return a.value op b.value;                                                                                         \
  }
COUNTED_OPERATOR(+)
COUNTED_OPERATOR(-) COUNTED_OPERATOR(*) COUNTED_OPERATOR(/) bool operator<(const Counted &a, const Counted &b) {
  return a.value < b.value;
}

/// Additions and multiplications of one of vectorized_math.h's polynomials.
Counted counted(double value, double flops) {
  Counted::flops += flops;
  return value;
}
Counted exp(const Counted &x) { return counted(std::exp(x.value), 33); }
Counted log(const Counted &x) { return counted(std::log(x.value), 32); }
Counted sqrt(const Counted &x) { return counted(std::sqrt(x.value), 1); }

double flops_of_a_cell(ep::Integrator integrator) {
  const auto model = ep::make_ionic_model("ttp06_epi");
  const ep::CellState cell = model->initial_state("limit_cycle");
  ep::ttp06::States<Counted> y_n, y_middle, y_np1;
  std::copy(cell.states.begin(), cell.states.end(), y_n.begin());
  Counted::flops = 0;
  const Counted v = 1e3 * cell.v;
  if (integrator == ep::Integrator::imex_euler) {
    ep::ttp06::step_gates(ep::ttp06::epi, v, y_n, y_np1, 1e3 * dt);
    ep::ttp06::finish_step(ep::ttp06::epi, v, y_n, y_np1, 1e3 * dt);
  } else {
    ep::ttp06::step_gates_midpoint(ep::ttp06::epi, v, y_n, y_middle, y_np1, 1e3 * dt);
    ep::ttp06::finish_step_midpoint(ep::ttp06::epi, v, y_n, y_middle, y_np1, 1e3 * dt);
  }
  return Counted::flops;
}

void ionic_step(benchmark::State &state, ep::Integrator integrator) {
  constexpr std::size_t n = 50000;
  const auto model = ep::make_ionic_model("ttp06_epi");
  const ep::CellState cell = model->initial_state("limit_cycle");
  const auto states_n = model->uniform_states(n, cell.states);
  auto states_np1 = states_n;
  std::vector<double> v(n, cell.v), current(n), error(n);
  for (auto _ : state)
    model->step(integrator, n, v.data(), states_n.data(), states_np1.data(), dt, current.data(), error.data());
  // read, and written with the line read before
  const double bytes = 8. * (3 * model->n_kept() + 3);
  compare_with_limit(state, {double(n), n * bytes, n * flops_of_a_cell(integrator)});
}
BENCHMARK_CAPTURE(ionic_step, imex_euler, ep::Integrator::imex_euler)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ionic_step, exponential_midpoint, ep::Integrator::exponential_midpoint)
    ->Unit(benchmark::kMillisecond);

/// The whole step while the wave spreads: an item is a node.
void electrophysiology_step(benchmark::State &state) {
  ep::Parameters parameters = scene().ep;
  parameters.automatic_substeps = false;
  const Wall wall(1);
  ep::EPSolver solver(wall.space, ep::conductivity(wall.space, wall.fibres, parameters.conductivity), parameters);
  bus::Step step{0, 0, 0, dt};
  const auto advance = [&] {
    step.time = ++step.number * dt;
    solver.solve_step(step);
    solver.commit_step(step);
  };
  while (step.time < 10e-3)
    advance();
  for (auto _ : state)
    advance();
  const double n = wall.space.n_owned_nodes();
  compare_with_limit(
      state, {n, n * 8 * (3. * ep::ttp06::n_kept + 3), n * flops_of_a_cell(ep::integrator(parameters.integrator))});
  state.counters["linear_iterations"] = solver.iterations();
}
BENCHMARK(electrophysiology_step)->Unit(benchmark::kMillisecond);

} // namespace

} // namespace heartbus::benchmarks
