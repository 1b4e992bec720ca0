#include "mech_solver/mech_solver.h"
#include "common/geometry/shapes.h"
#include "lonely_bus.h"
#include "mpi_test_main.h"

#include <spdlog/sinks/ostream_sink.h>
#include <sstream>

using namespace heartbus;
using namespace heartbus::mech;

namespace {

geometry::Parameters shape() {
  geometry::Parameters parameters;
  parameters.mesh = "MXS";
  return parameters;
}

mech::Parameters tight() {
  mech::Parameters parameters;
  parameters.solver.residual_tolerance = 1e-9;
  parameters.solver.linear_tolerance = 1e-6;
  return parameters;
}

/// A small ventricle, inflated.
struct Ventricle {
  std::ostringstream text;
  fem::LagrangeSpace space{MPI_COMM_WORLD, geometry::make_solid(shape())};
  fem::Fibres fibres{space, geometry::FibreParameters()};
  MechSolver solver;
  test::LonelyBus bus;
  bus::Step step{1, 0, 2e-4, 2e-4};

  explicit Ventricle(const mech::Parameters &parameters = tight())
      : solver(space, fibres, parameters,
               std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(text))) {
    solver.declare(bus);
    bus.tasks.at("inflate")(step);
  }
  const std::vector<double> &get(const std::string &field) const { return *bus.outputs.at(field); }
  void set(const std::string &field, const std::vector<double> &values) { *bus.inputs.at(field) = values; }
  void set_calcium(double value) { bus.inputs.at("calcium")->assign(space.n_owned_nodes(), value); }
};

/// Over all ranks.
double largest_difference(const std::vector<double> &a, const std::vector<double> &b) {
  double largest = 0;
  for (std::size_t k = 0; k < a.size(); ++k)
    largest = std::max(largest, std::abs(a[k] - b[k]));
  return dealii::Utilities::MPI::max(largest, MPI_COMM_WORLD);
}

double largest(const std::vector<double> &a) { return largest_difference(a, std::vector<double>(a.size())); }

} // namespace

TEST(MechSolver, InflatedWallStaysWhereItIs) {
  Ventricle wall;
  const std::vector<double> start = wall.get("displacement"), force = wall.get("wall_force");
  EXPECT_GT(largest(start), 1e-3);
  EXPECT_GT(largest(force), 1e-2);
  wall.solver.prepare_step(wall.step);
  EXPECT_EQ(largest(wall.get("wall_velocity")), 0);
  EXPECT_EQ(largest_difference(wall.get("wall_force"), force), 0) << "no calcium has come: no active increment";
  wall.set("blood_force", force);
  wall.solver.solve_step(wall.step);
  EXPECT_LT(largest_difference(wall.get("displacement"), start), 1e-10);
}

TEST(MechSolver, SaysWhichOfItsInterfaceNodesItHolds) {
  Ventricle wall;
  const std::vector<double> &held = wall.get("held"), &points = wall.bus.points.at("interface");
  ASSERT_EQ(held.size(), points.size());
  double n_held = 0;
  for (std::size_t k = 0; k < held.size(); ++k) {
    EXPECT_EQ(held[k], std::abs(points[k / 3 * 3 + 2] - 15e-3) < 1e-9) << "the rim lies in the base, which is fixed";
    n_held += held[k];
  }
  EXPECT_GT(dealii::Utilities::MPI::sum(n_held, MPI_COMM_WORLD), 0);
}

TEST(MechSolver, RollersHoldTheNormalOnly) {
  geometry::Parameters piston;
  piston.shape = "piston";
  mech::Parameters parameters;
  parameters.fixed = {};
  parameters.rollers = {"x_low", "x_high"};
  const fem::LagrangeSpace space(MPI_COMM_WORLD, geometry::make_solid(piston));
  geometry::FibreParameters rule;
  rule.rule = "constant";
  parameters.pericardium.labels = {"z_low"};
  const fem::Fibres fibres(space, rule);
  std::ostringstream text;
  MechSolver solver(space, fibres, parameters,
                    std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(text)));
  test::LonelyBus bus;
  solver.declare(bus);
  const std::vector<double> &held = *bus.outputs.at("held"), &points = bus.points.at("interface");
  for (std::size_t k = 0; k < held.size(); ++k) {
    const double x = points[k / 3 * 3];
    const bool on_a_side = x < 1e-9 || x > piston.piston.width - 1e-9;
    EXPECT_EQ(held[k], k % 3 == 0 && on_a_side) << "component " << k % 3 << " at x = " << x;
  }
}

TEST(MechSolver, FirstWallForceIsTheResidualAtTheNewTension) {
  Ventricle wall;
  const std::vector<double> old_force = wall.get("wall_force");
  wall.set_calcium(1.0);
  wall.solver.prepare_step(wall.step);
  EXPECT_GT(largest_difference(wall.get("wall_force"), old_force), 1e-9);
  // After the inflation there is neither inertia nor damping: the static forces are the whole residual.
  fem::Vector forces = wall.space.make_vector(3);
  wall.solver.problem().solid_forces(wall.solver.problem().past[0], forces);
  const auto on = wall.space.nodes_on("interface");
  std::vector<double> residual;
  for (unsigned i = 0; i < 3 * wall.space.n_owned_nodes(); ++i)
    if (on[i / 3])
      residual.push_back(forces.local_element(i));
  EXPECT_LT(largest_difference(wall.get("wall_force"), residual), 1e-12);
}

TEST(MechSolver, EveryIterationStartsFromTheOldState) {
  Ventricle wall;
  wall.set_calcium(0.6);
  wall.solver.prepare_step(wall.step);
  const std::vector<double> start = wall.get("displacement"), first = wall.get("wall_force");
  std::vector<double> second = first;
  for (double &value : second)
    value *= 1.5;
  wall.set("blood_force", first);
  wall.solver.solve_step(wall.step);
  const std::vector<double> displacement = wall.get("displacement");

  wall.set("blood_force", second);
  wall.step.iteration = 1;
  wall.solver.solve_step(wall.step);
  const std::vector<double> moved = wall.get("displacement");
  EXPECT_GT(largest_difference(moved, displacement), 1e-7);
  EXPECT_EQ(largest_difference(wall.get("wall_force"), second), 0);
  std::vector<double> velocity = moved;
  for (std::size_t k = 0; k < velocity.size(); ++k)
    velocity[k] = (moved[k] - start[k]) / wall.step.size;
  EXPECT_LT(largest_difference(wall.get("wall_velocity"), velocity), 1e-9);

  wall.set("blood_force", first);
  wall.step.iteration = 2;
  wall.solver.solve_step(wall.step);
  EXPECT_LT(largest_difference(wall.get("displacement"), displacement), 1e-10);
}

TEST(MechSolver, KnowsItsVolumeAndWhereSarcomeresAreClamped) {
  mech::Parameters parameters = tight();
  parameters.active.sarcomere_length = 1.5; // too short everywhere, whatever the inflation
  Ventricle wall(parameters);
  const auto whole = [&](const std::string &scalar) {
    return dealii::Utilities::MPI::sum(wall.bus.scalars.at(scalar)(), MPI_COMM_WORLD);
  };
  double own = 0; // volume as the inflation has left it, by the determinant of each cell's mean gradient
  const fem::GhostValues ghosts(wall.solver.problem().past[0]);
  for (unsigned batch = 0; batch < wall.space.n_owned_batches(); ++batch)
    for (unsigned q = 0; q < wall.space.n_q(); ++q)
      for (unsigned lane = 0; lane < fem::n_lanes; ++lane) {
        const unsigned slot = batch * fem::n_lanes + lane, n = wall.space.nodes_per_cell();
        dealii::Tensor<2, 3> F = dealii::unit_symmetric_tensor<3>();
        for (unsigned a = 0; a < n; ++a)
          for (unsigned i = 0; i < 3; ++i)
            for (unsigned j = 0; j < 3; ++j)
              F[i][j] += wall.solver.problem().past[0].begin()[3 * wall.space.cell_nodes(slot)[a] + i] *
                         wall.space.gradients(batch)[(q * n + a) * 3 + j][lane];
        if (wall.space.slot_owned(slot))
          own += dealii::determinant(F) * wall.space.JxW(batch)[q][lane];
      }
  const double rest = dealii::Utilities::MPI::sum(wall.solver.problem().own_volume_at_rest(), MPI_COMM_WORLD);
  EXPECT_GT(std::abs(whole("wall_volume") - 1), 1e-4);
  EXPECT_NEAR(whole("wall_volume"), dealii::Utilities::MPI::sum(own, MPI_COMM_WORLD) / rest, 1e-12);

  EXPECT_EQ(whole("clamped_share"), 0) << "no calcium has come";
  wall.set_calcium(0.1);
  wall.solver.prepare_step(wall.step);
  EXPECT_NEAR(whole("clamped_share"), 1, 1e-12);
}

TEST(MechSolver, ACrushedCellIsNamedWithWhatToLookAt) {
  mech::Parameters parameters;
  parameters.active.tension_max = 1e9;
  Ventricle wall(parameters);
  wall.step.size = 1e-3;
  wall.set("blood_force", wall.get("wall_force"));
  wall.set_calcium(1);
  try {
    for (wall.step.number = 1; wall.step.number < 1000; ++wall.step.number) {
      wall.step.time = wall.step.number * wall.step.size;
      wall.solver.prepare_step(wall.step);
      wall.solver.solve_step(wall.step);
      wall.solver.commit_step(wall.step);
    }
    FAIL() << "nothing was crushed";
  } catch (const Failure &failure) {
    EXPECT_EQ(failure.code(), ExitCode::not_finite) << failure.what();
    for (const char *part : {"t = 0.", "the wall is crushed in the cell around (", "at rest",
                             "now: J = det F = ", "tension_max", "sarcomere_length", "kappa", "fibres", "time.step"})
      EXPECT_NE(std::string(failure.what()).find(part), std::string::npos) << failure.what();
    if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
      std::cout << failure.what() << "\n";
  }
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
