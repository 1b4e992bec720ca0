#include "common/geometry/mesh_tools.h"
#include "ep_solver/conductivity.h"
#include "ep_solver/ep_solver.h"
#include "ep_solver/ionic/ttp06.h"
#include "mpi_test_main.h"
#include "tests/mms/conductivities.h"

#include <cmath>
#include <filesystem>

using namespace heartbus;

namespace {

double largest(double x) { return dealii::Utilities::MPI::max(x, MPI_COMM_WORLD); }

/// A bar along x, one cell thick, in the published state, stimulated over its first two millimetres.
struct Bar {
  ep::Parameters parameters;
  fem::LagrangeSpace space;
  ep::EPSolver solver;
  double time = 0;
  int number = 0;

  static geometry::Mesh mesh(double length, unsigned n_cells, bool tetrahedra) {
    const double h = length / n_cells;
    const geometry::Mesh bar = geometry::make_box({0, 0, 0}, {length, h, h}, {n_cells, 1, 1});
    return tetrahedra ? geometry::make_tetrahedra(bar) : bar;
  }
  /// `substeps` 0: as many as the error estimate asks for.
  static ep::Parameters make_parameters(int substeps, const std::string &integrator, const std::string &ionic_model) {
    ep::Parameters p;
    p.ionic_model = ionic_model;
    p.integrator = integrator;
    p.substeps = substeps;
    p.automatic_substeps = substeps == 0;
    p.initial_state = "published";
    p.tolerance = 1e-9;
    p.stimulus.duration = 2e-3;
    p.stimulus.sites = {{"cube", {0, 0, 0}, 2e-3}};
    return p;
  }
  Bar(double length, unsigned n_cells, const Conductivity &D, int substeps = 1,
      const std::string &integrator = "imex_euler", MPI_Comm communicator = MPI_COMM_WORLD, unsigned tetrahedra = 0,
      const std::string &ionic_model = "ttp06_epi")
      : parameters(make_parameters(substeps, integrator, ionic_model)),
        space(communicator, mesh(length, n_cells, tetrahedra > 0), 0, tetrahedra > 0 ? tetrahedra : 1),
        solver(space, D(space), parameters) {}
  Bar(const geometry::Mesh &mesh, const Conductivity &D)
      : parameters(make_parameters(1, "imex_euler", "ttp06_epi")), space(MPI_COMM_WORLD, mesh),
        solver(space, D(space), parameters) {}

  void run(int n_steps, double dt) {
    for (int n = 0; n < n_steps; ++n) {
      time += dt;
      const bus::Step step{++number, 0, time, dt};
      solver.solve_step(step);
      solver.commit_step(step);
    }
  }
  /// Activation of the nodes at x.
  double activation(double x) const {
    double t = -1;
    for (unsigned i = 0; i < space.n_owned_nodes(); ++i)
      if (std::abs(space.points()[i][0] - x) < 1e-9)
        t = std::max(t, solver.activation_times()[i]);
    return largest(t);
  }
  /// Of all ranks, as the bus combines them.
  double last_activation() const {
    constexpr double never = std::numeric_limits<double>::infinity();
    const double mine = solver.last_activation(), latest = largest(std::isnan(mine) ? never : mine);
    return latest == never ? std::numeric_limits<double>::quiet_NaN() : latest;
  }
  double speed(double x0, double x1) const { return (x1 - x0) / (activation(x1) - activation(x0)); }
};

Conductivity diagonal(double x, double y, double z) { return constant({{{x, 0, 0}, {0, y, 0}, {0, 0, z}}}); }

} // namespace

TEST(Monodomain, WithoutDiffusionEveryNodeFollowsTheSingleCell) {
  Bar bar(2e-3, 4, diagonal(0, 0, 0));
  const auto model = ep::make_ionic_model("ttp06_epi");
  ep::CellState cell = model->initial_state("published");
  double v_max = cell.v;
  for (int n = 0; n < 100; ++n) {
    bar.run(1, 2e-4);
    const double i_app = n < 10 ? 35.714 : 0;
    cell.v += 2e-4 * (i_app - model->step_cell(ep::Integrator::imex_euler, cell.v, cell.states, 2e-4, 0));
    v_max = std::max(v_max, cell.v);
    for (unsigned i = 0; i < bar.space.n_owned_nodes(); ++i)
      EXPECT_NEAR(bar.solver.potential().local_element(i), cell.v, 1e-7)
          << "step " << n; // a return would hang other ranks
  }
  EXPECT_GT(v_max, 0.03); // it did fire
  for (const double calcium : bar.solver.calcium())
    EXPECT_NEAR(calcium, 1e3 * cell.states[model->calcium_state()], 1e-7);
}

/// Speed on one-dimensional linear elements, consistent mass, same scheme and step, by an independent program; a lumped
/// mass gives 0.417 m/s.
TEST(Monodomain, WaveOnCoarseCellsTravelsAtTheSpeedOfTheReference) {
  Bar bar(30e-3, 30, diagonal(1.68e-4, 0.5e-4, 0.2e-4));
  bar.run(260, 2e-4);
  EXPECT_NEAR(bar.speed(10e-3, 25e-3), 0.651, 0.01 * 0.651);
}

/// On cells of one millimetre, the wave of quadratic tetrahedra travels about as fast as on fine ones.
TEST(Monodomain, WaveOnQuadraticTetrahedraIsCloserToThatOfFineCells) {
  const Conductivity D = diagonal(1.68e-4, 1.68e-4, 1.68e-4);
  const auto speed = [&](unsigned n_cells, unsigned degree) {
    Bar bar(30e-3, n_cells, D, 1, "imex_euler", MPI_COMM_WORLD, degree);
    bar.run(260, 2e-4);
    return bar.speed(10e-3, 25e-3);
  };
  const double fine = speed(120, 1);
  EXPECT_LT(std::abs(speed(30, 2) / fine - 1), 0.5 * std::abs(speed(30, 1) / fine - 1));
}

/// A bar with its fibres, sheets or normals along it; reference as above (lumped 0.616, 0.354 and 0.124 m/s).
TEST(Monodomain, WaveIsFastestAlongTheFibres) {
  struct {
    std::vector<double> fibre, sheet;
    double speed;
    int n_steps;
  } const cases[] = {
      {{1, 0, 0}, {0, 1, 0}, 0.758, 150}, {{0, 1, 0}, {1, 0, 0}, 0.494, 220}, {{0, 1, 0}, {0, 0, 1}, 0.217, 450}};
  for (const auto &c : cases) {
    geometry::FibreParameters fibres;
    fibres.rule = "constant";
    fibres.direction = c.fibre;
    fibres.sheet = c.sheet;
    Bar bar(20e-3, 40, [&](const fem::LagrangeSpace &space) {
      return ep::conductivity(space, fem::Fibres(space, fibres), ep::ConductivityParameters());
    });
    bar.run(c.n_steps, 2e-4);
    EXPECT_NEAR(bar.speed(5e-3, 15e-3), c.speed, 0.015 * c.speed)
        << "fibres along " << c.fibre[0] << c.fibre[1] << c.fibre[2];
  }
}

/// The far half of a bar conducts as across the fibres: the front is slow there, in either half as in a bar of its own.
TEST(Monodomain, ARegionHasItsOwnConductivity) {
  geometry::FibreParameters fibres;
  fibres.rule = "constant";
  ep::ConductivityParameters parameters;
  parameters.regions["slow"] = {0.769e-4, 0.769e-4, 0.769e-4};
  geometry::Mesh mesh = Bar::mesh(40e-3, 80, false);
  mesh.material_names = {"muscle", "slow"};
  mesh.materials.assign(mesh.n_cells(), 0);
  for (unsigned c = 0; c < mesh.n_cells(); ++c)
    mesh.materials[c] = mesh.points[mesh.cells[8 * c]][0] > 19.9e-3;
  Bar bar(mesh, [&](const fem::LagrangeSpace &space) {
    return ep::conductivity(space, fem::Fibres(space, fibres), parameters);
  });
  bar.run(400, 2e-4);
  EXPECT_NEAR(bar.speed(5e-3, 15e-3), 0.758, 0.015 * 0.758);
  EXPECT_NEAR(bar.speed(25e-3, 35e-3), 0.494, 0.02 * 0.494);
}

TEST(Monodomain, ActivationIsReportedWhenAllNodesAreActive) {
  Bar bar(10e-3, 20, diagonal(1.68e-4, 1.68e-4, 1.68e-4));
  bar.run(25, 2e-4); // 5 ms
  EXPECT_GT(bar.activation(0), 0);
  EXPECT_TRUE(std::isnan(bar.last_activation()));
  bar.run(75, 2e-4);
  EXPECT_DOUBLE_EQ(bar.last_activation(), bar.activation(10e-3));
  EXPECT_GT(bar.activation(10e-3), bar.activation(5e-3));
}

TEST(Monodomain, SubstepsAreSmallerSteps) {
  Bar whole(5e-3, 10, diagonal(1.68e-4, 1.68e-4, 1.68e-4)), split(5e-3, 10, diagonal(1.68e-4, 1.68e-4, 1.68e-4), 4);
  whole.run(40, 1e-4);
  split.run(10, 4e-4);
  for (unsigned i = 0; i < whole.space.n_owned_nodes(); ++i) {
    EXPECT_NEAR(whole.solver.potential().local_element(i), split.solver.potential().local_element(i), 1e-12);
    EXPECT_NEAR(whole.solver.calcium()[i], split.solver.calcium()[i], 1e-12);
  }
}

TEST(Monodomain, SolvingAgainStartsFromTheSameOldState) {
  for (const auto &[substeps, integrator] :
       {std::pair(2, "imex_euler"), {2, "exponential_midpoint"}, {0, "exponential_midpoint"}}) {
    const Conductivity D = diagonal(1.68e-4, 1.68e-4, 1.68e-4);
    Bar once(5e-3, 10, D, substeps, integrator), twice(5e-3, 10, D, substeps, integrator);
    for (int n = 0; n < 20; ++n) {
      once.run(1, 2e-4);
      twice.solver.solve_step({n + 1, 0, twice.time + 2e-4, 2e-4});
      twice.run(1, 2e-4);
    }
    for (unsigned i = 0; i < once.space.n_owned_nodes(); ++i)
      EXPECT_EQ(once.solver.potential().local_element(i), twice.solver.potential().local_element(i)) << integrator;
  }
}

/// By the time at which a wave has passed ten millimetres, against a step of 0.003 ms.
TEST(Monodomain, OrderOfTheIntegratorsInTissue) {
  const auto arrival = [](const std::string &integrator, double dt) {
    Bar bar(10e-3, 20, diagonal(1.68e-4, 1.68e-4, 1.68e-4), 1, integrator);
    bar.run(int(std::lround(14e-3 / dt)), dt);
    return bar.activation(10e-3);
  };
  const double exact = arrival("exponential_midpoint", 3.125e-6);
  const auto order = [&](const std::string &integrator) {
    return std::log2((arrival(integrator, 2.5e-5) - exact) / (arrival(integrator, 1.25e-5) - exact));
  };
  EXPECT_NEAR(order("imex_euler"), 1, 0.15);
  EXPECT_GT(order("exponential_midpoint"), 1.7);
}

/// Short substeps while a wave passes, long ones before and after, and the wave is as fast as with short ones always.
TEST(Monodomain, SubstepsAreAsShortAsTheWaveAsks) {
  Bar bar(10e-3, 20, diagonal(1.68e-4, 1.68e-4, 1.68e-4), 0, "exponential_midpoint"),
      fine(10e-3, 20, diagonal(1.68e-4, 1.68e-4, 1.68e-4), 32, "exponential_midpoint");
  bar.run(20, 4e-4); // 8 ms: the wave is inside
  EXPECT_GE(bar.solver.substeps(), 4u);
  bar.run(80, 4e-4); // 40 ms: it has passed
  EXPECT_LE(bar.solver.substeps(), 1u);
  fine.run(40, 4e-4);
  EXPECT_NEAR(bar.activation(10e-3), fine.activation(10e-3), 0.012 * fine.activation(10e-3));
}

/// Cells that take a step at once and cells that take its substeps, beside each other, each as if alone.
TEST(Monodomain, FastAndSlowCellsTakeTheirOwnSteps) {
  const auto model = ep::make_ionic_model("ttp06_epi");
  const auto midpoint = ep::Integrator::exponential_midpoint;
  const unsigned n_nodes = 11;
  const auto start = model->uniform_states(n_nodes, model->initial_state("published").states);
  std::vector<double> v(n_nodes), I(n_nodes), error(n_nodes), I_slow(n_nodes);
  for (unsigned node = 0; node < n_nodes; ++node)
    v[node] = -0.09 + 0.01 * node;
  std::vector<char> is_fast(n_nodes, false);
  for (const unsigned node : {1u, 2u, 7u, 10u})
    is_fast[node] = true;
  ep::Cells cells(*model, midpoint, n_nodes);
  cells.begin_step(start, v.data(), 2e-4, is_fast);
  auto slow = start, fast = start, mixed = start;
  model->step(midpoint, n_nodes, v.data(), start.data(), slow.data(), 2e-4, I_slow.data(), error.data());
  std::vector<double> I_fast(n_nodes);
  for (int k = 0; k < 2; ++k) {
    cells.substep(v.data(), 1e-4, I.data());
    model->step(midpoint, n_nodes, v.data(), fast.data(), fast.data(), 1e-4, I_fast.data(), error.data());
    for (unsigned node = 0; node < n_nodes; ++node)
      EXPECT_EQ(I[node], is_fast[node] ? I_fast[node] : I_slow[node]) << node;
  }
  cells.end_step(mixed);
  const unsigned n_kept = model->n_kept();
  for (unsigned node = 0; node < n_nodes; ++node)
    for (unsigned s = 0; s < n_kept; ++s) {
      const std::size_t k = node / fem::n_lanes * n_kept + s, lane = node % fem::n_lanes;
      EXPECT_EQ(mixed[k][lane], (is_fast[node] ? fast : slow)[k][lane]) << node;
    }
  EXPECT_NE(slow[ep::ttp06::Ca_i][1], fast[ep::ttp06::Ca_i][1]); // or nothing was compared
}

/// Where nothing happens, electrophysiology goes several steps of the coupling at once; what it sends within is as
/// right as with steps of its own, and a run goes on from there with the same bits.
TEST(Monodomain, GoesAheadWhereNothingHappens) {
  const Conductivity D = diagonal(1.68e-4, 1.68e-4, 1.68e-4);
  Bar bar(5e-3, 10, D, 0, "exponential_midpoint"), fine(5e-3, 10, D, 4, "exponential_midpoint");
  bar.run(2000, 1e-4); // 200 ms
  fine.run(2000, 1e-4);
  int computed = 0;
  for (int n = 0; n < 50; ++n) {
    bar.run(1, 1e-4);
    fine.run(1, 1e-4);
    computed += bar.solver.substeps() > 0;
    EXPECT_GE(bar.solver.end(), bar.time - 1e-12);
    for (unsigned i = 0; i < bar.space.n_owned_nodes(); ++i)
      EXPECT_NEAR(bar.solver.calcium()[i], fine.solver.calcium()[i], 2e-3 * fine.solver.calcium()[i]);
  }
  EXPECT_LE(computed, 7); // 0.8 ms each
  while (bar.solver.substeps() > 0 || bar.solver.end() < bar.time + 2.5e-4)
    bar.run(1, 1e-4);
  const std::string folder =
      testing::TempDir() + "ahead_on_" + std::to_string(dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD));
  if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
    std::filesystem::create_directories(folder);
  MPI_Barrier(MPI_COMM_WORLD);
  const bus::Step now{bar.number, 0, bar.time, 1e-4};
  bar.solver.save_state(folder, now);
  Bar again(5e-3, 10, D, 0, "exponential_midpoint");
  again.solver.load_state(folder, now);
  again.time = bar.time;
  again.number = bar.number;
  EXPECT_EQ(again.solver.calcium(), bar.solver.calcium());
  for (int n = 0; n < 20; ++n) {
    bar.run(1, 1e-4);
    again.run(1, 1e-4);
    EXPECT_EQ(again.solver.substeps(), bar.solver.substeps());
    EXPECT_EQ(again.solver.calcium(), bar.solver.calcium());
  }
}

/// The minimal model takes the same substeps, steps ahead and checkpoints.
TEST(Monodomain, TheMinimalModelIsAsRightWithStepsOfItsOwnChoiceAndGoesOnWithTheSameBits) {
  const Conductivity D = diagonal(1.68e-4, 1.68e-4, 1.68e-4);
  const auto bar_of = [&](int substeps, const std::string &integrator) {
    return std::make_unique<Bar>(10e-3, 20, D, substeps, integrator, MPI_COMM_WORLD, 0, "bueno_orovio_epi");
  };
  const auto bar = bar_of(0, "exponential_midpoint"), fine = bar_of(64, "exponential_midpoint"),
             euler = bar_of(64, "imex_euler");
  unsigned most = 0;
  for (int n = 0; n < 150; ++n) { // 60 ms
    bar->run(1, 4e-4);
    most = std::max(most, bar->solver.substeps());
  }
  fine->run(150, 4e-4);
  euler->run(150, 4e-4);
  EXPECT_GE(most, 4u);
  EXPECT_LE(bar->solver.substeps(), 1u);
  EXPECT_NEAR(bar->activation(10e-3), fine->activation(10e-3), 0.012 * fine->activation(10e-3));
  EXPECT_NEAR(euler->activation(10e-3), fine->activation(10e-3), 0.012 * fine->activation(10e-3));
  for (unsigned i = 0; i < bar->space.n_owned_nodes(); ++i) {
    EXPECT_NEAR(bar->solver.calcium()[i], fine->solver.calcium()[i], 0.01 * fine->solver.calcium()[i]);
    EXPECT_NEAR(bar->solver.potential().local_element(i), fine->solver.potential().local_element(i), 1e-3);
  }
  const std::string folder =
      testing::TempDir() + "minimal_on_" + std::to_string(dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD));
  if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
    std::filesystem::create_directories(folder);
  MPI_Barrier(MPI_COMM_WORLD);
  const bus::Step now{bar->number, 0, bar->time, 4e-4};
  bar->solver.save_state(folder, now);
  const auto again = bar_of(0, "exponential_midpoint");
  again->solver.load_state(folder, now);
  again->time = bar->time;
  again->number = bar->number;
  for (int n = 0; n < 20; ++n) {
    bar->run(1, 4e-4);
    again->run(1, 4e-4);
    EXPECT_EQ(again->solver.calcium(), bar->solver.calcium());
  }
}

/// A beat begins with a step of its own, and no activation is reported before its time.
TEST(Monodomain, StepsAheadEndWithTheBeat) {
  Bar bar(5e-3, 10, diagonal(1.68e-4, 1.68e-4, 1.68e-4), 0, "exponential_midpoint");
  while (bar.time < 0.8 - 1e-7) {
    bar.run(1, 5e-5);
    EXPECT_LE(bar.solver.end(), 0.8 + 1e-9);
    EXPECT_TRUE(!(bar.last_activation() > bar.time));
  }
  bar.run(1, 5e-5);
  EXPECT_GT(bar.solver.substeps(), 0u);
  EXPECT_TRUE(std::isnan(bar.last_activation()));
}

/// Steps end where those of the coupling do, after many of them too: rounding does not add up.
TEST(Monodomain, StepsAheadStayOnTheStepsOfTheCoupling) {
  Bar bar(2e-3, 4, diagonal(1.68e-4, 1.68e-4, 1.68e-4), 0, "exponential_midpoint");
  const double dt = 1e-4;
  for (int n = 1; n <= 24000; ++n) { // three beats
    const bus::Step step{n, 0, n * dt, dt};
    bar.solver.solve_step(step);
    bar.solver.commit_step(step);
    ASSERT_NEAR(bar.solver.end(), std::round(bar.solver.end() / dt) * dt, 1e-11 * dt) << "step " << n;
  }
  EXPECT_NEAR(bar.solver.end(), 2.4, 1e-9);
}

/// All ranks together decide as one alone.
TEST(Monodomain, SubstepsDoNotDependOnRanks) {
  const Conductivity D = diagonal(1.68e-4, 1.68e-4, 1.68e-4);
  Bar all(10e-3, 20, D, 0, "exponential_midpoint"), alone(10e-3, 20, D, 0, "exponential_midpoint", MPI_COMM_SELF);
  for (int n = 0; n < 50; ++n) {
    all.run(1, 4e-4);
    alone.run(1, 4e-4);
    EXPECT_EQ(all.solver.substeps(), alone.solver.substeps()) << "step " << n;
  }
  for (unsigned i = 0; i < all.space.n_owned_nodes(); ++i)
    for (unsigned k = 0; k < alone.space.n_owned_nodes(); ++k) {
      const bool same_node = all.space.points()[i] == alone.space.points()[k];
      EXPECT_TRUE(!same_node ||
                  std::abs(all.solver.potential().local_element(i) - alone.solver.potential().local_element(k)) < 1e-7);
    }
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
