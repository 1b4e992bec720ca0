#include "ale_solver/lifting_problem.h"
#include "common/geometry/shapes.h"
#include "common/nonlinear/anderson.h"
#include "fluid_solver/fluid_solver.h"
#include "fluid_test.h"
#include "fsi_solver/fsi_problem.h"
#include "lonely_bus.h"
#include "mech_solver/mech_solver.h"
#include "mpi_test_main.h"

#include <spdlog/sinks/null_sink.h>

using namespace heartbus;
using fem::Vector;

namespace {

constexpr double dt = 2e-4;
enum class Valve { none, closed, aortic, mitral };

/// What a run is made of: a ventricle whose tension rises or falls, or a piston that is pushed from its far end.
struct Scene {
  geometry::Parameters geometry;
  geometry::FibreParameters fibres;
  mech::Parameters mech;
  fluid::Parameters fluid;
  ale::Parameters ale;
  Valve valve = Valve::none;
  double tension = 0, tension_rate = 0; ///< [Pa], [Pa/s]

  Scene() {
    mech.solver.residual_tolerance = 1e-11;
    mech.solver.update_tolerance = 1e-9;
    fluid.tolerance = ale.tolerance = 1e-12;
  }
};

Scene ventricle(Valve valve, double tension, double tension_rate, const std::string &cells = "hexahedra") {
  Scene scene;
  scene.geometry.cells = cells;
  scene.geometry.mesh = "MXS";
  scene.valve = valve;
  scene.tension = tension;
  scene.tension_rate = tension_rate;
  scene.fluid.valves.aortic_pressure = 1300;
  scene.fluid.valves.mitral_pressure = 1600;
  return scene;
}

Scene piston() {
  Scene scene;
  scene.geometry.shape = "piston";
  scene.geometry.piston.cells_across = 2;
  scene.geometry.piston.cells_column = scene.geometry.piston.cells_fluid = 3;
  scene.fibres.rule = "constant";
  scene.mech.law = "neo_hookean";
  scene.mech.neo_hookean = {12e3, 50e3};
  scene.mech.fixed = {};
  scene.mech.rollers = scene.fluid.slip = scene.ale.slip = {"x_low", "x_high", "y_low", "y_high"};
  scene.mech.pericardium = {{"z_low"}, 1e4, 0, 2e4, 0};
  scene.mech.initial_pressure = scene.fluid.initial_pressure = 0;
  scene.mech.loads["push"] = {"z_low", {{0, 10 * dt}, {0, 500}}};
  scene.fluid.no_slip = scene.ale.fixed = {"z_high"};
  return scene;
}

/// Blood and wall with their history, solved by whoever: the derived classes say how.
struct Run {
  Run(const Scene &scene, double alpha)
      : scene(scene), cavity(MPI_COMM_WORLD, geometry::make_fluid(scene.geometry)),
        wall(MPI_COMM_WORLD, geometry::make_solid(scene.geometry)), fibres(wall, scene.fibres),
        lifting(cavity, scene.ale), map(cavity, wall), fluid(cavity, scene.fluid, alpha, dt),
        solid(wall, fibres, scene.mech), d(wall.make_vector(3)), motion(cavity.make_vector(3)) {
    if (scene.valve != Valve::none) {
      fluid.add_orifice("mitral", scene.fluid.valves.mitral_pressure, 0).open = scene.valve == Valve::mitral;
      fluid.add_orifice("aortic", scene.fluid.valves.aortic_pressure, 1.3e7).open = scene.valve == Valve::aortic;
    }
    set_tension(0);
    for (int step = 1; step <= 5; ++step) {
      solid.interface_pressure = step / 5. * scene.mech.initial_pressure;
      solid.solve_static(d);
    }
    solid.interface_pressure = 0;
    solid.past.fill(d);
    fluid.start(lifted());
  }
  virtual ~Run() = default;
  virtual void solve() = 0;

  void advance(int n_steps) {
    for (int step = 1; step <= n_steps; ++step) {
      set_tension(step * dt);
      solid.time = step * dt;
      fluid.prepare(lifted());
      d.sadd(2, -1, solid.past[1]);
      solve();
      fluid.commit();
      solid.past.push(d);
    }
  }
  void set_tension(double time) { solid.tension = scene.tension + time * scene.tension_rate; }
  const Vector &lifted() {
    const Vector on_interface = to_fluid(solid.past[0]);
    for (const unsigned node : map.fluid_nodes())
      for (unsigned i = 0; i < 3; ++i)
        motion.local_element(3 * node + i) = on_interface.local_element(4 * node + i);
    lifting.lift(motion);
    return motion;
  }
  /// 1 where the wall does not move, on the fluid's nodes.
  Vector held() const {
    Vector v = wall.make_vector(3);
    for (unsigned k = 0; k < v.locally_owned_size(); ++k)
      v.local_element(k) = solid.constrained()[k];
    return to_fluid(v);
  }
  Vector to_fluid(const Vector &v) const {
    std::vector<double> values;
    for (const unsigned node : map.solid_nodes())
      values.insert(values.end(), v.begin() + 3 * node, v.begin() + 3 * node + 3);
    values = map.to_fluid(values, 3);
    Vector result = cavity.make_vector(4);
    for (std::size_t k = 0; k < values.size(); ++k)
      result.local_element(4 * map.fluid_nodes()[k / 3] + k % 3) = values[k];
    return result;
  }
  Vector to_solid(const Vector &v) const {
    std::vector<double> values;
    for (const unsigned node : map.fluid_nodes())
      values.insert(values.end(), v.begin() + 4 * node, v.begin() + 4 * node + 3);
    values = map.to_solid(values, 3);
    Vector result = wall.make_vector(3);
    for (std::size_t k = 0; k < values.size(); ++k)
      result.local_element(3 * map.solid_nodes()[k / 3] + k % 3) = values[k];
    return result;
  }

  Scene scene;
  fem::LagrangeSpace cavity, wall;
  fem::Fibres fibres;
  ale::LiftingProblem lifting;
  fsi::InterfaceMap map;
  fluid::NavierStokesProblem fluid;
  mech::ElasticityProblem solid;
  Vector d, motion;
};

struct Monolithic : Run {
  explicit Monolithic(const Scene &scene) : Run(scene, 0), problem(fluid, solid, dt) {}
  void solve() override {
    const auto statistics = problem.solve_step(d);
    newton_iterations += statistics.iterations;
    linear_iterations += statistics.linear_iterations;
  }
  fsi::FsiProblem problem;
  unsigned newton_iterations = 0, linear_iterations = 0;
};

/// Iterates L -> d with R_s(d) = L -> u, p with the Robin datum made of (d - d^n)/dt and L -> L until the force L on
/// the wall stays.
struct RobinNeumann : Run {
  explicit RobinNeumann(const Scene &scene) : Run(scene, 5000), L(cavity.make_vector(4)) { fluid.hold(held()); }

  Vector iterate(int iteration) {
    solid.load = to_solid(L);
    solid.solve_dynamic(dt, d);
    Vector v = d;
    v -= solid.past[0];
    v *= 1 / dt;
    fluid.solve(to_fluid(v), L, iteration);
    return fluid.blood_force();
  }
  void solve() override {
    fem::Anderson<Vector> acceleration(12);
    for (int iteration = 0;; ++iteration) {
      const Vector g = iterate(iteration);
      if (test::largest_difference(g, L) <= 1e-10 * g.linfty_norm() + 1e-14)
        return;
      ASSERT_LT(iteration, 60) << "the interface force does not settle";
      L = acceleration.next(L, g);
    }
  }
  Vector L;
};

/// The largest values of the velocities and of the pressures of a state [m/s], [Pa].
std::array<double, 2> largest(const Run &run, const Vector &state) {
  std::array<double, 2> value{};
  for (unsigned k = 0; k < state.locally_owned_size(); ++k)
    value[k % 4 == 3] = std::max(value[k % 4 == 3], std::abs(state.local_element(k)));
  value[1] *= run.fluid.pressure_scale();
  for (double &v : value)
    v = dealii::Utilities::MPI::max(v, MPI_COMM_WORLD);
  return value;
}

void expect_the_monolithic_step(const Scene &scene) {
  Monolithic a(scene);
  RobinNeumann b(scene);
  const Vector d_0 = a.d;
  Vector change = a.fluid.state();
  b.L = b.fluid.blood_force();
  a.advance(10);
  b.advance(10);
  const double d_change = test::largest_difference(a.d, d_0);
  Vector difference = a.fluid.state();
  change -= a.fluid.state();
  difference -= b.fluid.state();
  const auto [u_change, p_change] = largest(a, change);
  const auto [u_error, p_error] = largest(a, difference);
  EXPECT_GT(d_change, 1e-6);
  EXPECT_GT(p_change, 100);
  EXPECT_LT(test::largest_difference(a.d, b.d), 1e-7 * d_change);
  EXPECT_LT(u_error, 1e-7 * std::max(u_change, d_change / dt / 10)); // a closed piston cannot move its interface
  EXPECT_LT(p_error, 1e-7 * p_change);
  EXPECT_LT(a.newton_iterations, 70u);
  EXPECT_LT(a.linear_iterations, 450u);
}

} // namespace

TEST(MonolithicStep, IsWhereRobinNeumannIterationsOfAPistonEnd) { expect_the_monolithic_step(piston()); }

TEST(MonolithicStep, IsWhereRobinNeumannIterationsOfAContractingVentricleEnd) {
  expect_the_monolithic_step(ventricle(Valve::closed, 1e3, 2e6));
}

TEST(MonolithicStep, IsWhereRobinNeumannIterationsOfAnEjectingVentricleEnd) {
  expect_the_monolithic_step(ventricle(Valve::aortic, 1e3, 2e6));
}

TEST(MonolithicStep, IsWhereRobinNeumannIterationsOfAnEjectingVentricleOfTetrahedraEnd) {
  expect_the_monolithic_step(ventricle(Valve::aortic, 1e3, 2e6, "tetrahedra"));
}

TEST(MonolithicStep, IsWhereRobinNeumannIterationsOfAFillingVentricleEnd) {
  expect_the_monolithic_step(ventricle(Valve::mitral, 5e3, -1e6));
}

/// What mech_solver tells fluid_solver over the bus, and what fsi_solver takes from the wall itself.
void expect_the_same_held(Valve valve) {
  Scene scene = ventricle(valve, 1e3, 2e6);
  scene.fluid.valves.aortic_pressure = valve == Valve::aortic ? 1300 : 9000; // the blood stands at 1333 Pa
  scene.fluid.valves.mitral_pressure = valve == Valve::mitral ? 1600 : 1333;
  Monolithic merged(scene);
  merged.fluid.prepare(merged.lifted());

  const auto log = std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::null_sink_mt>());
  mech::MechSolver wall(merged.wall, merged.fibres, scene.mech, log);
  test::LonelyBus of_wall, of_blood;
  wall.declare(of_wall);
  fluid::FluidSolver blood(merged.cavity, scene.fluid, interface::BloodSettings{}, dt, log);
  blood.declare(of_blood);
  *of_blood.inputs.at("held") = merged.map.to_fluid(*of_wall.outputs.at("held"), 3);
  of_blood.tasks.at("hold")({});
  of_blood.tasks.at("start")({});
  blood.prepare_step({1, 0, 30e-3, dt});
  ASSERT_EQ(blood.valves()->aortic_open(), valve == Valve::aortic);
  ASSERT_EQ(blood.valves()->mitral_open(), valve == Valve::mitral);
  EXPECT_EQ(blood.problem().constraints(), merged.fluid.constraints());
}

TEST(MonolithicStep, HoldsWhatThePartitionedSchemesHoldWithClosedValves) { expect_the_same_held(Valve::closed); }
TEST(MonolithicStep, HoldsWhatThePartitionedSchemesHoldWithAnOpenAorticValve) { expect_the_same_held(Valve::aortic); }
TEST(MonolithicStep, HoldsWhatThePartitionedSchemesHoldWithAnOpenMitralValve) { expect_the_same_held(Valve::mitral); }

TEST(MonolithicStep, ConservesTheVolumeOfAClosedCavity) {
  Monolithic run(ventricle(Valve::closed, 1e3, 2e6));
  const double volume = run.fluid.volume();
  run.advance(20);
  EXPECT_GT(run.fluid.mean_pressure(), 1500);
  const double speed = largest(run, run.fluid.state())[0], area = 1e-2;
  EXPECT_LT(std::abs(run.fluid.unit_pressure_force() * run.fluid.state()), 1e-9 * speed * area);
  EXPECT_NEAR(run.fluid.volume() / volume, 1, 1e-5); // the geometry is a step behind
}

TEST(MonolithicStep, BalancesTheForcesOfBloodAndWall) {
  Monolithic run(ventricle(Valve::aortic, 1e3, 2e6));
  run.advance(4); // the matrix, in single precision, is as exact as the start is near
  run.set_tension(5 * dt);
  run.fluid.prepare(run.lifted());
  run.solve();
  Vector on_blood = run.fluid.reaction(), on_wall = run.wall.make_vector(3); // -a_f, evaluated afresh, and R_s
  fem::zero_constrained(on_blood, run.fluid.constraints());
  run.solid.residual(run.d, on_wall);
  EXPECT_LT(test::largest_difference(run.to_solid(on_blood), on_wall), 1e-9 * on_wall.linfty_norm());
  EXPECT_EQ(test::largest_difference(run.to_fluid(on_wall), run.problem.blood_force()), 0);
}

TEST(MonolithicStep, NamesTheCellThatIsCrushed) {
  Monolithic run(ventricle(Valve::aortic, 1e3, 1e9));
  try {
    run.advance(1000);
    FAIL() << "nothing was crushed";
  } catch (const Failure &failure) {
    EXPECT_EQ(failure.code(), ExitCode::not_finite) << failure.what();
    EXPECT_NE(std::string(failure.what()).find("the wall is crushed in the cell around ("), std::string::npos)
        << failure.what();
  }
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
