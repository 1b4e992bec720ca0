#include "fluid_solver/fluid_solver.h"
#include "ale_solver/ale_solver.h"
#include "common/geometry/shapes.h"
#include "fluid_test.h"
#include "lonely_bus.h"
#include "mpi_test_main.h"

#include <numeric>
#include <spdlog/sinks/ostream_sink.h>
#include <sstream>

using namespace heartbus;
using namespace heartbus::test;

namespace {

/// A small ventricle whose wall does as it is told: it is held at the base, does not move elsewhere, and presses with a
/// given pressure.
struct Ventricle {
  static geometry::Parameters shape() {
    geometry::Parameters parameters;
    parameters.mesh = "MXS";
    return parameters;
  }
  static fluid::Parameters accurate() {
    fluid::Parameters parameters;
    parameters.tolerance = 1e-10; // the balance of mass is as good as the linear solver
    return parameters;
  }
  std::ostringstream text;
  fem::LagrangeSpace space{MPI_COMM_WORLD, geometry::make_fluid(shape())};
  fluid::FluidSolver solver;
  LonelyBus bus;
  bus::Step step{0, 0, 0, 2e-4};

  Ventricle()
      : solver(space, accurate(), {interface::BloodSettings::Condition::robin, 5000}, 2e-4,
               std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(text))) {
    solver.declare(bus);
    *bus.inputs.at("held") = rim();
    std::fill(bus.inputs.at("wall_velocity")->begin(), bus.inputs.at("wall_velocity")->end(), 0.);
    bus.tasks.at("hold")(step);
    bus.tasks.at("start")(step);
  }
  /// 1 at the interface's nodes in the base, else 0; three times a node.
  std::vector<double> rim() const {
    const std::vector<double> &points = bus.points.at("interface");
    std::vector<double> held;
    for (std::size_t k = 0; k < points.size(); ++k)
      held.push_back(std::abs(points[k / 3 * 3 + 2] - 15e-3) < 1e-9);
    return held;
  }
  /// A wall sends no force where it is held.
  std::vector<double> force_of(double p) const {
    const fem::Vector force = interface_force(space, zero, pressure(p));
    const auto on = space.nodes_on("interface");
    const std::vector<double> held = rim();
    std::vector<double> values;
    for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
      for (unsigned i = 0; on[node] && i < 3; ++i)
        values.push_back(held[values.size()] ? 0 : force.local_element(4 * node + i));
    return values;
  }
  /// The largest velocity of the blood at the rim.
  double speed_at_the_rim() const {
    const auto on = space.nodes_on("interface");
    const std::vector<double> held = rim();
    double largest = 0;
    for (unsigned node = 0, k = 0; node < space.n_owned_nodes(); ++node)
      for (unsigned i = 0; on[node] && i < 3; ++i, ++k)
        if (held[k])
          largest = std::max(largest, std::abs(solver.problem().state().local_element(4 * node + i)));
    return dealii::Utilities::MPI::max(largest, MPI_COMM_WORLD);
  }
  void advance(double p, int iterations = 1) {
    ++step.number;
    step.time = step.number * step.size;
    solver.prepare_step(step);
    *bus.inputs.at("wall_force") = force_of(p);
    for (step.iteration = 0; step.iteration < iterations; ++step.iteration)
      solver.solve_step(step);
    bus.tasks.at("budget")(step);
    solver.commit_step(step);
  }
  double value(const std::string &scalar) const { return bus.scalars.at(scalar)(); }
};

} // namespace

TEST(FluidSolver, DeclaresWhatTheOthersExpect) {
  Ventricle lv;
  EXPECT_EQ(lv.bus.points.at("cavity").size(), lv.bus.inputs.at("mesh_motion")->size());
  EXPECT_EQ(lv.bus.points.at("interface").size(), lv.bus.inputs.at("wall_velocity")->size());
  EXPECT_EQ(lv.bus.points.at("interface").size(), lv.bus.inputs.at("wall_force")->size());
  EXPECT_EQ(lv.bus.points.at("interface").size(), lv.bus.outputs.at("blood_force")->size());
  EXPECT_NEAR(lv.value("mean_pressure"), 1333, 1e-6);
  EXPECT_NEAR(lv.value("volume"), 83e-6, 8e-6);
}

TEST(FluidSolver, OpensTheAorticValveUnderPressureAndClosesItWhenTheFlowReverses) {
  Ventricle lv;
  const double dt = lv.step.size;
  int opened = 0;
  for (int n = 1; n <= 60 && !opened; ++n) {
    lv.advance(1333 + n * 400);
    if (lv.bus.states.at("phase")() == fluid::Valves::ejection)
      opened = n;
    else
      EXPECT_EQ(lv.value("aortic_flow"), 0);
  }
  ASSERT_GT(opened * dt, 3.8e-3); // not below the aortic pressure
  EXPECT_GT(lv.value("aortic_flow"), 0);
  for (int n = 0; n < 30; ++n)
    lv.advance(12000);
  EXPECT_GT(lv.value("aortic_flow"), 1e-5);
  EXPECT_GT(lv.value("mean_pressure"), 9000);
  for (int n = 0; n < 400 && lv.bus.states.at("phase")() == fluid::Valves::ejection; ++n)
    lv.advance(6000);
  EXPECT_EQ(lv.bus.states.at("phase")(), fluid::Valves::isovolumetric_relaxation);
  EXPECT_EQ(lv.value("aortic_flow"), 0);
  EXPECT_NE(lv.text.str().find("aortic valve opens: pressure"), std::string::npos);
  EXPECT_NE(lv.text.str().find("aortic valve closes: its flow"), std::string::npos);
}

TEST(FluidSolver, HoldsTheBloodWhereTheWallIsHeldWhateverValveIsOpen) {
  Ventricle lv;
  for (int n = 0; n < 45; ++n)
    lv.advance(9500);
  ASSERT_EQ(lv.bus.states.at("phase")(), fluid::Valves::ejection);
  EXPECT_GT(lv.solver.problem().state().linfty_norm(), 0.01);
  EXPECT_EQ(lv.speed_at_the_rim(), 0);
}

TEST(FluidSolver, AValveThatOpensLetsNothingBack) {
  Ventricle lv;
  for (int n = 1; n <= 60; ++n) {
    lv.advance(9000 + 10 * n);
    if (lv.bus.states.at("phase")() == fluid::Valves::ejection) {
      EXPECT_GT(lv.value("aortic_flow"), 0) << "step " << n;
    }
  }
  EXPECT_EQ(lv.bus.states.at("phase")(), fluid::Valves::ejection);
}

TEST(FluidSolver, BudgetIsTheFlowThroughTheValveWhenTheWallIsAtRest) {
  Ventricle lv;
  for (int n = 0; n < 45; ++n)
    lv.advance(9500);
  ASSERT_EQ(lv.bus.states.at("phase")(), fluid::Valves::ejection);
  EXPECT_NEAR(lv.value("volume_defect"), -lv.value("aortic_flow"), 1e-6 * lv.value("aortic_flow"));
  EXPECT_LT(lv.value("interface_power"), 0); // the pressure pushes outwards, the blood leaves the wall inwards
}

TEST(FluidSolver, IterationsOfAStepEndWhereTheFirstOneDidForTheSameData) {
  Ventricle once, twice;
  for (int n = 0; n < 3; ++n) {
    once.advance(2000);
    twice.advance(2000, 2);
  }
  const auto &a = *once.bus.outputs.at("blood_force"), &b = *twice.bus.outputs.at("blood_force");
  for (std::size_t k = 0; k < a.size(); ++k)
    EXPECT_NEAR(a[k], b[k], 1e-7);
}

TEST(ALESolver, LiftsWhatTheBusBringsAndGuessesWellFromItsHistory) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, geometry::make_fluid(Ventricle::shape()));
  ale::ALESolver solver(space, ale::Parameters{});
  LonelyBus bus;
  solver.declare(bus);
  const auto &points = bus.points.at("interface");
  auto &displacement = *bus.inputs.at("displacement");
  double first = 0;
  bus::Step step{0, 0, 0, 1e-3};
  for (step.number = 1; step.number <= 4; ++step.number) {
    for (std::size_t k = 0; k < points.size(); ++k) // inwards, zero at the base
      displacement[k] = k % 3 == 2 ? 0 : -0.01 * step.number * points[k] * (15e-3 - points[k / 3 * 3 + 2]) / 77e-3;
    solver.prepare_step(step);
    solver.solve_step(step);
    solver.commit_step(step);
    if (step.number == 1)
      first = bus.scalars.at("lifting_iterations")();
  }
  EXPECT_GT(first, 0);
  EXPECT_LE(bus.scalars.at("lifting_iterations")(), 3); // a motion at constant speed is guessed
  const auto &motion = *bus.outputs.at("mesh_motion"), &cavity = bus.points.at("cavity");
  ASSERT_EQ(motion.size(), cavity.size());
  double outwards = 0;
  for (std::size_t k = 0; k < motion.size(); ++k)
    outwards += k % 3 == 2 ? 0 : motion[k] * cavity[k];
  EXPECT_LT(sum(outwards), 0);
}

namespace {

/// A box full of blood, 10 x 10 x 10 mm, behind an interface at its low end.
struct Box {
  std::ostringstream text;
  fem::LagrangeSpace space;
  fluid::FluidSolver solver;
  LonelyBus bus;
  bus::Step step{1, 0, 2e-4, 2e-4};

  static geometry::Parameters shape() {
    geometry::Parameters parameters;
    parameters.shape = "piston";
    return parameters;
  }
  static fluid::Parameters blood(bool closed) {
    fluid::Parameters parameters;
    parameters.no_slip = closed ? std::vector<std::string>{"z_high"} : std::vector<std::string>{};
    parameters.slip = {"x_low", "x_high", "y_low", "y_high"};
    return parameters;
  }
  explicit Box(bool closed, interface::Alternation alternation = interface::Alternation::steps)
      : space(MPI_COMM_WORLD, geometry::make_fluid(shape())),
        solver(space, blood(closed), {interface::BloodSettings::Condition::robin, 5000, alternation}, 2e-4,
               std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(text))) {
    solver.declare(bus);
    bus.tasks.at("begin_probe")(step);
  }
  /// The nodal forces of a pressure p(x) = 1 + tilt x / (10 mm), as far as they are free.
  std::vector<double> force(double tilt) const {
    const auto stress = [tilt](const Point3 &x) { return -(1 + tilt * x[0] / 10e-3) * fem::identity<double>(); };
    const fem::Vector nodal = interface_force(space, zero, stress);
    const auto on = space.nodes_on("interface");
    std::vector<double> values;
    for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
      for (unsigned i = 0; on[node] && i < 3; ++i)
        values.push_back(i == 2 ? nodal.local_element(4 * node + i) : 0);
    return values;
  }
  std::vector<double> velocity_under(const std::vector<double> &force) {
    *bus.inputs.at("probe_force") = force;
    bus.tasks.at("probe")(step);
    ++step.iteration;
    return *bus.outputs.at("probe_velocity");
  }
};

double dot(const std::vector<double> &a, const std::vector<double> &b) {
  return sum(std::inner_product(a.begin(), a.end(), b.begin(), 0.));
}

} // namespace

TEST(FluidSolver, BloodInAnOpenBoxYieldsAsItsMassSays) {
  // rho l (u - u^n)/dt = -p; when it alternates from step to step, u - u^n = 2 u.
  for (const auto alternation : {interface::Alternation::steps, interface::Alternation::iterations}) {
    Box box(false, alternation);
    const bool of_steps = alternation == interface::Alternation::steps;
    const double mass = 1060 * 10e-3 * 1e-4, inertia = (of_steps ? 2 : 1) * mass / 2e-4;
    const std::vector<double> force = box.force(0), u = box.velocity_under(force);
    EXPECT_NEAR(dot(force, u) * inertia, -1e-8, 1e-12) << "1 Pa times 1 cm^2, to the tolerance of probes";
  }
}

TEST(FluidSolver, BloodInAClosedBoxYieldsToLocalMotionsOnly) {
  Box closed(true);
  const std::vector<double> uniform = closed.force(0), tilted = closed.force(1);
  const std::vector<double> rests = closed.velocity_under(uniform), yields = closed.velocity_under(tilted);
  EXPECT_LT(std::sqrt(dot(rests, rests)), 1e-4 * std::sqrt(dot(yields, yields)));
  EXPECT_LT(dot(tilted, yields), 0);
}

TEST(FluidSolver, YieldingIsSymmetricAndAgainstTheForce) {
  Box open(false);
  const std::vector<double> f = open.force(0), g = open.force(1);
  const std::vector<double> u = open.velocity_under(f), v = open.velocity_under(g);
  EXPECT_LT(dot(g, v), 0);
  EXPECT_NEAR(dot(f, v) / dot(g, u), 1, 0.02) << "but for the stabilisation";
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
