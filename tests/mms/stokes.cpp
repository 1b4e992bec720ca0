#include "fluid_test.h"
#include "mpi_test_main.h"

using namespace heartbus;
using namespace heartbus::test;

namespace {

// A velocity without divergence, -Lap u = 5 u, and a pressure.
Point3 exact_velocity(const Point3 &x) {
  return {std::sin(x[1] + 2 * x[2]), std::sin(x[2] + 2 * x[0]), std::sin(x[0] + 2 * x[1])};
}
double exact_pressure(const Point3 &x) { return std::sin(2 * x[0]) * std::cos(x[1]) + x[2]; }
Point3 body_force(const Point3 &x) {
  const Point3 u = exact_velocity(x);
  return {5 * u[0] + 2 * std::cos(2 * x[0]) * std::cos(x[1]), 5 * u[1] - std::sin(2 * x[0]) * std::sin(x[1]),
          5 * u[2] + 1};
}
fem::Mat3<double> exact_stress(const Point3 &x) {
  const double a = std::cos(x[1] + 2 * x[2]), b = std::cos(x[2] + 2 * x[0]), c = std::cos(x[0] + 2 * x[1]);
  fem::Mat3<double> grad{{{{0, a, 2 * a}, {2 * b, 0, b}, {c, 2 * c, 0}}}};
  return grad + fem::transpose(grad) - exact_pressure(x) * fem::identity<double>();
}

/// Errors of one huge time step from rest: the Stokes equations, with viscosity 1 and a Robin condition on one face.
std::array<double, 2> stokes_errors(unsigned n, bool tetrahedra, const std::string &preconditioner) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, cube(n, {"a", "b", "c", "d", "e", "interface"}, tetrahedra));
  fluid::Parameters parameters;
  parameters.density = parameters.viscosity = 1;
  parameters.no_slip = {"a", "b", "c", "d", "e"};
  parameters.preconditioner = preconditioner;
  fluid::NavierStokesProblem problem(space, parameters, 2., 1e12);
  const fem::Vector exact = flow(space, zero, exact_velocity, exact_pressure, problem.pressure_scale());
  problem.boundary_values = exact;
  problem.body_force = body_force;
  problem.start(motion(space, zero));
  problem.prepare(motion(space, zero));
  problem.solve(exact, interface_force(space, zero, exact_stress));
  return errors(problem, zero, exact_velocity, exact_pressure);
}

} // namespace

TEST(Stokes, ConvergesWithOrderTwoInVelocityAndOneInPressureOnHexahedra) {
  const auto coarse = stokes_errors(4, false, "ilu"), fine = stokes_errors(8, false, "ilu");
  EXPECT_GT(std::log2(coarse[0] / fine[0]), 1.85);
  EXPECT_GT(std::log2(coarse[1] / fine[1]), 1.);
  EXPECT_LT(fine[0], 2e-2); // about the error of interpolation
}

TEST(Stokes, ConvergesWithOrderTwoInVelocityAndOneInPressureOnTetrahedra) {
  const auto coarse = stokes_errors(4, true, "ilu"), fine = stokes_errors(8, true, "ilu");
  EXPECT_GT(std::log2(coarse[0] / fine[0]), 1.7);
  EXPECT_GT(std::log2(coarse[1] / fine[1]), 1.);
  EXPECT_LT(fine[0], 2e-2);
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
