#include "common/base/failure.h"
#include "fluid_test.h"
#include "mpi_test_main.h"

#include <algorithm>

using namespace heartbus;
using namespace heartbus::test;

namespace {

const std::vector<std::string> walls{"a", "b", "c", "d", "e"};
const std::vector<std::string> one_interface{"a", "b", "c", "d", "e", "interface"};

Field moving_mesh(double t) {
  return [t](const Point3 &X) {
    const double s = 0.08 * std::sin(3 * t);
    return Point3{s * std::sin(3 * X[1] + X[2]), s * std::cos(2 * X[0] - X[2]),
                  s * std::sin(3 * X[0] + 2 * X[1]) + 2 * s};
  };
}

/// A solution of the Navier-Stokes equations with a body force, at any time.
struct Solution {
  std::function<Point3(const Point3 &, double)> u, f;
  std::function<double(const Point3 &, double)> p;
  std::function<fem::Mat3<double>(const Point3 &, double)> stress;
};

template <class F>
auto at(const F &function, double t) {
  return [function, t](const Point3 &x) { return function(x, t); };
}

/// Errors at t = end after n_steps on the moving unit cube; density 2, viscosity 0.1.
std::array<double, 2> errors_on_moving_mesh(const Solution &exact, const geometry::Mesh &mesh, int n_steps,
                                            double end) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, mesh);
  fluid::Parameters parameters;
  parameters.density = 2;
  parameters.viscosity = 0.1;
  parameters.no_slip = walls;
  parameters.tolerance = 1e-11;
  const double dt = end / n_steps;
  fluid::NavierStokesProblem problem(space, parameters, 3., dt);
  const double scale = problem.pressure_scale();
  problem.start(motion(space, moving_mesh(0)));
  problem.old_state() = flow(space, moving_mesh(0), at(exact.u, 0), at(exact.p, 0), scale);
  for (int step = 1; step <= n_steps; ++step) {
    const double t = step * dt;
    const Field d = moving_mesh(t);
    problem.boundary_values = flow(space, d, at(exact.u, t), at(exact.p, t), scale);
    problem.body_force = at(exact.f, t);
    problem.prepare(motion(space, d));
    problem.solve(problem.boundary_values, interface_force(space, d, at(exact.stress, t)));
    problem.commit();
  }
  return errors(problem, moving_mesh(end), at(exact.u, end), at(exact.p, end));
}

/// u = A(t) x, p = g(t).x: the finite elements hold it exactly, so only the error of the time step is left.
Solution linear_in_space() {
  const auto A = [](double t) {
    const double a = std::sin(2 * t), b = std::exp(-t);
    return fem::Mat3<double>{{{{a, b, 0.5}, {1 - b, -2 * a, a * a}, {b, -1., a}}}};
  };
  const auto rate = [](double t) {
    const double a = std::sin(2 * t), da = 2 * std::cos(2 * t), db = -std::exp(-t);
    return fem::Mat3<double>{{{{da, db, 0}, {-db, -2 * da, 2 * a * da}, {db, 0, da}}}};
  };
  const auto g = [](double t) { return Point3{1 + t, std::cos(t), -2 * t}; };
  Solution s;
  s.u = [A](const Point3 &x, double t) { return A(t) * x; };
  s.p = [g](const Point3 &x, double t) { return fem::dot(g(t), x); };
  s.f = [A, rate, g](const Point3 &x, double t) {
    const Point3 acceleration = (rate(t) + A(t) * A(t)) * x, gradient = g(t);
    return Point3{2 * acceleration[0] + gradient[0], 2 * acceleration[1] + gradient[1],
                  2 * acceleration[2] + gradient[2]};
  };
  s.stress = [A, p = s.p](const Point3 &x, double t) {
    return 0.1 * (A(t) + fem::transpose(A(t))) - p(x, t) * fem::identity<double>();
  };
  return s;
}

/// u = cos(t) (sin(y + 2z), sin(z + 2x), sin(x + 2y)), -Lap u = 5 u.
Solution trigonometric() {
  const auto U = [](const Point3 &x) {
    return Point3{std::sin(x[1] + 2 * x[2]), std::sin(x[2] + 2 * x[0]), std::sin(x[0] + 2 * x[1])};
  };
  const auto gradient = [](const Point3 &x) {
    const double a = std::cos(x[1] + 2 * x[2]), b = std::cos(x[2] + 2 * x[0]), c = std::cos(x[0] + 2 * x[1]);
    return fem::Mat3<double>{{{{0, a, 2 * a}, {2 * b, 0, b}, {c, 2 * c, 0}}}};
  };
  Solution s;
  s.u = [U](const Point3 &x, double t) {
    const Point3 u = U(x);
    return Point3{std::cos(t) * u[0], std::cos(t) * u[1], std::cos(t) * u[2]};
  };
  s.p = [](const Point3 &x, double t) { return std::sin(x[0] + x[1] - x[2] + t); };
  s.f = [U, gradient](const Point3 &x, double t) {
    const Point3 u = U(x), convection = gradient(x) * u;
    const double c = std::cos(t), dp = std::cos(x[0] + x[1] - x[2] + t);
    Point3 f;
    for (unsigned i = 0; i < 3; ++i)
      f[i] = 2 * (-std::sin(t) * u[i] + c * c * convection[i]) + 0.1 * 5 * c * u[i] + (i == 2 ? -dp : dp);
    return f;
  };
  s.stress = [gradient, p = s.p](const Point3 &x, double t) {
    return (0.1 * std::cos(t)) * (gradient(x) + fem::transpose(gradient(x))) - p(x, t) * fem::identity<double>();
  };
  return s;
}

/// A cube of blood, 10 mm wide, whose top is the interface; dt = 0.2 ms, alpha = 5000. `sides`: label of all others.
struct BloodBox {
  fem::LagrangeSpace space;
  fluid::Parameters parameters;
  fluid::NavierStokesProblem problem;
  static geometry::Mesh mesh() {
    geometry::Mesh mesh = geometry::make_box({0, 0, 0}, {10e-3, 10e-3, 10e-3}, {4, 4, 4});
    mesh.labels = one_interface;
    return mesh;
  }
  static fluid::Parameters adjust(bool slip, const std::string &preconditioner) {
    fluid::Parameters p;
    (slip ? p.slip : p.no_slip) = walls;
    if (slip)
      p.no_slip.clear();
    p.preconditioner = preconditioner;
    p.tolerance = 1e-11;
    return p;
  }
  explicit BloodBox(bool slip, const std::string &preconditioner = "ilu")
      : space(MPI_COMM_WORLD, mesh()), parameters(adjust(slip, preconditioner)),
        problem(space, parameters, 5000, 2e-4) {
    problem.start(motion(space, zero));
  }
  /// A force on the interface without the entries of the rim, which is held.
  fem::Vector free_part(fem::Vector force) const {
    const auto on = space.nodes_on("interface");
    for (unsigned k = 0; k < force.locally_owned_size(); ++k)
      if (!on[k / 4] || k % 4 == 3 || problem.constraints()[k])
        force.local_element(k) = 0;
    return force;
  }
  fem::Vector constant(const Point3 &v) const {
    return flow(
        space, zero, [v](const Point3 &) { return v; }, [](const Point3 &) { return 0.; }, 1);
  }
};

/// Something happens: the wall pushes unevenly, the mesh moves.
struct Disturbed : BloodBox {
  fem::Vector v, W;
  explicit Disturbed(const std::string &preconditioner = "ilu") : BloodBox(false, preconditioner) {
    const Field d = [](const Point3 &X) {
      return Point3{0, 1e-5 * std::sin(300 * X[1]), 2e-5 * std::cos(200 * X[0]) * X[2] / 10e-3};
    };
    v = flow(
        space, zero,
        [](const Point3 &X) {
          return Point3{0.01, 0, 0.1 * std::cos(300 * X[0])};
        },
        [](const Point3 &) { return 0.; }, 1);
    W = interface_force(space, d, pressure(2000));
    problem.prepare(motion(space, d));
  }
};

} // namespace

TEST(NavierStokes, HasOrderOneInTimeOnAMovingMesh) {
  for (const bool tetrahedra : {false, true}) {
    const geometry::Mesh mesh = cube(4, one_interface, tetrahedra);
    const auto coarse = errors_on_moving_mesh(linear_in_space(), mesh, 8, 0.4),
               fine = errors_on_moving_mesh(linear_in_space(), mesh, 16, 0.4);
    EXPECT_NEAR(std::log2(coarse[0] / fine[0]), 1, 0.15);
    EXPECT_NEAR(std::log2(coarse[1] / fine[1]), 1, 0.25);
    EXPECT_LT(fine[0], 0.05);
  }
}

TEST(NavierStokes, HasOrderTwoInSpaceOnAMovingMesh) {
  for (const bool tetrahedra : {false, true}) {
    const auto coarse = errors_on_moving_mesh(trigonometric(), cube(4, one_interface, tetrahedra), 2, 0.1),
               fine = errors_on_moving_mesh(trigonometric(), cube(8, one_interface, tetrahedra), 8, 0.1);
    EXPECT_GT(std::log2(coarse[0] / fine[0]), tetrahedra ? 1.6 : 1.8);
    EXPECT_GT(std::log2(coarse[1] / fine[1]), 1);
  }
}

TEST(NavierStokes, PreservesAUniformFlowOnAMovingMesh) {
  Solution uniform;
  uniform.u = [](const Point3 &, double) { return Point3{1, -2, 0.5}; };
  uniform.p = [](const Point3 &, double) { return 3.; };
  uniform.f = [](const Point3 &, double) { return Point3{}; };
  uniform.stress = [](const Point3 &, double) { return -3. * fem::identity<double>(); };
  const auto e = errors_on_moving_mesh(uniform, cube(3, one_interface), 4, 1.);
  EXPECT_LT(e[0], 1e-10);
  EXPECT_LT(e[1], 1e-9);
}

TEST(NavierStokes, ConvergesToPoiseuilleFlowWithOrderTwo) {
  const auto profile = [](const Point3 &x) { return Point3{4 * x[1] * (1 - x[1]), 0, 0}; };
  const auto drop = [](const Point3 &x) { return 8 * (1 - x[0]); }; // mu = 1
  const auto stress = [&](const Point3 &x) {
    fem::Mat3<double> s = -drop(x) * fem::identity<double>();
    s[0][1] = s[1][0] = 4 - 8 * x[1];
    return s;
  };
  std::array<double, 2> error[2];
  for (const unsigned level : {0, 1}) {
    const fem::LagrangeSpace space(MPI_COMM_WORLD,
                                   cube(4 << level, {"inlet", "interface", "low", "high", "front", "back"}));
    fluid::Parameters parameters;
    parameters.density = parameters.viscosity = 1;
    parameters.no_slip = {"inlet", "low", "high"};
    parameters.slip = {"front", "back"};
    fluid::NavierStokesProblem problem(space, parameters, 1., 1e10);
    const fem::Vector exact = flow(space, zero, profile, drop, problem.pressure_scale());
    problem.start(motion(space, zero));
    problem.old_state() = problem.boundary_values = exact;
    problem.prepare(motion(space, zero));
    problem.solve(exact, interface_force(space, zero, stress));
    error[level] = errors(problem, zero, profile, drop);
  }
  EXPECT_GT(std::log2(error[0][0] / error[1][0]), 1.9);
  EXPECT_LT(error[1][0], 0.02); // about the error of interpolation
  EXPECT_LT(error[1][1], 0.2);
}

TEST(NavierStokes, AClosedBoxAtRestKeepsItsPressure) {
  BloodBox box(false);
  const fem::Vector W = interface_force(box.space, zero, pressure(box.parameters.initial_pressure));
  for (int step = 0; step < 3; ++step) {
    box.problem.prepare(motion(box.space, zero));
    box.problem.solve(box.constant({0, 0, 0}), W);
    box.problem.commit();
  }
  EXPECT_NEAR(box.problem.mean_pressure(), box.parameters.initial_pressure, 1e-3);
  EXPECT_NEAR(box.problem.volume(), 1e-6, 1e-15);
  EXPECT_GT(box.problem.blood_force().linfty_norm(), 0.9 * W.linfty_norm());
  EXPECT_LT(largest_difference(box.problem.blood_force(), box.free_part(W)), 1e-7 * W.linfty_norm());
}

TEST(NavierStokes, AWallThatLeavesAClosedBoxLowersThePressureByAlphaTimesItsVelocity) {
  BloodBox box(true);
  const double v = 0.02;
  box.problem.prepare(motion(box.space, zero));
  const fem::Vector W = interface_force(box.space, zero, pressure(1333));
  box.problem.solve(box.constant({0, 0, v}), W);
  box.problem.commit();
  EXPECT_NEAR(box.problem.mean_pressure(), 1333 - 5000 * v, 1e-4);
  EXPECT_NEAR(box.problem.budget(box.constant({0, 0, v})).volume_defect, -v * 1e-4, 1e-12);
}

TEST(NavierStokes, AnOverpressureOfTheBloodPushesTheWallOutwards) {
  BloodBox box(true);
  box.problem.prepare(motion(box.space, zero));
  box.problem.solve(box.constant({0, 0, 0}), interface_force(box.space, zero, pressure(1000)));
  fem::Vector up = box.constant({0, 0, 1});
  EXPECT_NEAR(box.problem.blood_force() * up, 1000 * 1e-4,
              1e-8); // the closed box takes the wall's pressure, signs agree
}

TEST(NavierStokes, ReturnsTheReactionOfTheMomentumEquationAsForceOnTheWall) {
  Disturbed box;
  for (const int iteration : {0, 1}) {
    box.problem.solve(box.v, box.W, iteration);
    const fem::Vector L = box.problem.blood_force();
    EXPECT_LT(largest_difference(box.free_part(box.problem.reaction()), L), 1e-7 * L.linfty_norm());
    box.W = L;
  }
}

TEST(NavierStokes, CanBeSolvedAgainFromTheSameOldState) {
  Disturbed box;
  box.problem.solve(box.v, box.W);
  const fem::Vector first = box.problem.state();
  fem::Vector other = box.W;
  other *= 1.1;
  box.problem.solve(box.v, other, 1);
  EXPECT_GT(largest_difference(first, box.problem.state()), 1e-3);
  box.problem.solve(box.v, box.W, 2);
  EXPECT_LT(largest_difference(first, box.problem.state()), 1e-6 * first.linfty_norm());
  box.problem.solve(box.v, box.W, 0);
  EXPECT_EQ(largest_difference(first, box.problem.state()), 0);
}

TEST(NavierStokes, BothPreconditionersGiveTheSameAnswer) {
  Disturbed ilu("ilu"), simplec("simplec");
  const unsigned a = ilu.problem.solve(ilu.v, ilu.W).iterations,
                 b = simplec.problem.solve(simplec.v, simplec.W).iterations;
  EXPECT_LT(largest_difference(ilu.problem.state(), simplec.problem.state()), 1e-7 * ilu.problem.state().linfty_norm());
  EXPECT_LT(a, 60u);
  EXPECT_LT(b, 60u);
}

/// Plug flow through a duct with slipping sides: inflow 0.3 m/s over 1 cm^2, a resistance at the other end.
TEST(NavierStokes, AResistanceOutletHoldsThePressureThatItsFlowAsksFor) {
  geometry::Mesh mesh = geometry::make_box({0, 0, 0}, {30e-3, 10e-3, 10e-3}, {6, 3, 3});
  mesh.labels = {"inlet", "aortic", "a", "b", "c", "d"};
  const fem::LagrangeSpace space(MPI_COMM_WORLD, mesh);
  fluid::Parameters parameters;
  parameters.no_slip = {"inlet"};
  parameters.slip = {"a", "b", "c", "d"};
  parameters.tolerance = 1e-12;
  fluid::NavierStokesProblem problem(space, parameters, 0, 2e-4);
  fluid::Orifice &outlet = problem.add_orifice("aortic", 9000, 1.3e7);
  const fem::Vector plug = flow(
      space, zero,
      [](const Point3 &) {
        return Point3{0.3, 0, 0};
      },
      [](const Point3 &) { return 0.; }, 1);
  problem.start(motion(space, zero));
  problem.old_state() = problem.boundary_values = plug;
  outlet.open = true;
  const auto advance = [&] {
    problem.prepare(motion(space, zero));
    problem.solve(plug, plug);
    problem.commit();
  };
  advance(); // the pressure jumps: what the matrix, in single precision, makes of that is right to 1e-6
  EXPECT_NEAR(outlet.flux * problem.state(), 0.3e-4, 3e-6 * 0.3e-4);
  for (unsigned step = 0; step < 4; ++step)
    advance(); // the next starts overshoot; then small corrections of an exact residual
  EXPECT_NEAR(outlet.flux * problem.state(), 0.3e-4, 1e-12);
  EXPECT_NEAR(problem.mean_pressure(), 9000 + 1.3e7 * 0.3e-4, 1e-4);
}

TEST(NavierStokes, AClosedOrificeIsAWall) {
  geometry::Mesh mesh = geometry::make_box({0, 0, 0}, {10e-3, 10e-3, 10e-3}, {3, 3, 3});
  mesh.labels = {"base", "base2", "base3", "base4", "aortic", "interface"};
  const fem::LagrangeSpace space(MPI_COMM_WORLD, mesh);
  fluid::Parameters parameters;
  parameters.no_slip = {"base", "base2", "base3", "base4"};
  fluid::NavierStokesProblem problem(space, parameters, 5000, 2e-4);
  fluid::Orifice &outlet = problem.add_orifice("aortic", 1000, 0);
  const fem::Vector nothing = space.make_vector(4);
  problem.start(motion(space, zero));
  for (const bool open : {false, true, false}) {
    outlet.open = open;
    problem.prepare(motion(space, zero));
    problem.solve(nothing, interface_force(space, zero, pressure(3000)));
    problem.commit();
    const double flux = outlet.flux * problem.state();
    if (open)
      EXPECT_GT(flux, 1e-6);
    else
      EXPECT_LT(std::abs(flux), 1e-15);
  }
}

TEST(NavierStokes, RefusesAMeshMotionThatInvertsACellAndNamesIt) {
  BloodBox box(false);
  try {
    box.problem.prepare(motion(box.space, [](const Point3 &X) { return Point3{X[0] > 9e-3 ? -4e-3 : 0, 0, 0}; }));
    FAIL();
  } catch (const Failure &failure) {
    EXPECT_EQ(failure.code(), ExitCode::not_finite);
    EXPECT_NE(std::string(failure.what()).find("(8.75, "), std::string::npos) << failure.what();
  }
}

TEST(NavierStokes, RefusesSlipWallsThatAreNotFlatAlongTheAxes) {
  geometry::Mesh mesh = cube(2, walls);
  mesh.labels = {"corner", "interface"};
  for (auto &face : mesh.faces)
    face.label = face.label == 0 || face.label == 2 ? 0 : 1;
  const fem::LagrangeSpace space(MPI_COMM_WORLD, mesh);
  fluid::Parameters parameters;
  parameters.no_slip.clear();
  parameters.slip = {"corner"};
  fluid::NavierStokesProblem problem(space, parameters, 1, 1);
  problem.start(motion(space, zero));
  EXPECT_THROW(problem.prepare(motion(space, zero)), Failure);
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
