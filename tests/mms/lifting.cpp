#include "ale_solver/lifting_problem.h"
#include "common/base/failure.h"
#include "fluid_test.h"
#include "mpi_test_main.h"

using namespace heartbus;
using namespace heartbus::test;

namespace {

const std::vector<std::string> fixed_walls{"a", "b", "c", "d", "e"};

/// Components that are harmonic: exp(sqrt(2) x) sin y sin z and the like, small enough not to invert cells.
Point3 harmonic(const Point3 &x) {
  const double r = std::sqrt(2.);
  return {0.02 * std::exp(r * x[0]) * std::sin(x[1]) * std::sin(x[2]),
          0.02 * std::exp(r * x[1]) * std::sin(x[0]) * std::cos(x[2]), 0.05 * (x[0] * x[0] - x[2] * x[2])};
}

ale::Parameters all_fixed() {
  ale::Parameters parameters;
  parameters.fixed = fixed_walls;
  parameters.tolerance = 1e-12;
  return parameters;
}

/// Largest error at the nodes after lifting the boundary values of `d` from a zero guess.
double nodal_error(const geometry::Mesh &mesh, const Field &d) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, mesh);
  ale::LiftingProblem problem(space, all_fixed());
  const fem::Vector exact = motion(space, d);
  fem::Vector lifted = space.make_vector(3);
  for (unsigned k = 0; k < lifted.locally_owned_size(); ++k)
    if (problem.prescribed(k / 3, k % 3))
      lifted.local_element(k) = exact.local_element(k);
  EXPECT_GT(problem.lift(lifted), 0u);
  return largest_difference(lifted, exact);
}

} // namespace

TEST(Lifting, ConvergesWithOrderTwoToAHarmonicMotion) {
  // On a distorted mesh: on a uniform one the nodes would be more exact than that.
  const auto distorted = [](unsigned n) {
    geometry::Mesh mesh = cube(n, {"a", "b", "c", "d", "e", "interface"});
    for (auto &x : mesh.points)
      for (unsigned i = 0; i < 3; ++i)
        x[i] += 0.05 * std::sin(2 * M_PI * x[i]) * std::cos(3 * x[(i + 1) % 3]);
    return mesh;
  };
  const double coarse = nodal_error(distorted(4), harmonic), fine = nodal_error(distorted(8), harmonic);
  EXPECT_GT(std::log2(coarse / fine), 1.7);
  EXPECT_GT(std::log2(nodal_error(cube(3, {"a", "b", "c", "d", "e", "interface"}, true), harmonic) /
                      nodal_error(cube(6, {"a", "b", "c", "d", "e", "interface"}, true), harmonic)),
            1.6);
}

TEST(Lifting, ReproducesAffineMotionsExactly) {
  const Field affine = [](const Point3 &x) {
    return Point3{0.1 + 0.2 * x[0] - 0.1 * x[2], 0.3 * x[1], -0.2 * x[0] + 0.1 * x[1]};
  };
  EXPECT_LT(nodal_error(cube(3, {"a", "b", "c", "d", "e", "interface"}), affine), 1e-11);
  EXPECT_LT(nodal_error(cube(2, {"a", "b", "c", "d", "e", "interface"}, true), affine), 1e-11);
}

/// A piston: the top moves down, the sides let the mesh slide, the bottom stays.
TEST(Lifting, LetsTheMeshSlideAlongFlatWalls) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, cube(4, {"a", "b", "c", "d", "bottom", "interface"}));
  ale::Parameters parameters = all_fixed();
  parameters.fixed = {"bottom"};
  parameters.slip = {"a", "b", "c", "d"};
  ale::LiftingProblem problem(space, parameters);
  const fem::Vector exact = motion(space, [](const Point3 &X) { return Point3{0, 0, -0.3 * X[2]}; });
  const auto top = space.nodes_on("interface");
  fem::Vector lifted = space.make_vector(3);
  for (unsigned k = 0; k < lifted.locally_owned_size(); ++k)
    if (top[k / 3])
      lifted.local_element(k) = exact.local_element(k);
  problem.lift(lifted);
  EXPECT_LT(largest_difference(lifted, exact), 1e-11);
  EXPECT_NEAR(problem.smallest_J(), 0.7, 1e-10);
  EXPECT_EQ(problem.lift(lifted), 0u); // the last motion already solves it
}

TEST(Lifting, RefusesAMotionThatInvertsACellAndNamesIt) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, cube(4, {"a", "b", "c", "d", "bottom", "interface"}));
  ale::Parameters parameters = all_fixed();
  parameters.fixed = {"bottom"};
  parameters.slip = {"a", "b", "c", "d"};
  ale::LiftingProblem problem(space, parameters);
  fem::Vector lifted = motion(space, [](const Point3 &X) { return Point3{0, 0, X[2] > 0.99 ? -1.1 : 0}; });
  try {
    problem.lift(lifted);
    FAIL();
  } catch (const Failure &failure) {
    EXPECT_EQ(failure.code(), ExitCode::not_finite);
    for (const char *part : {"inverts the cell around (", ") mm at rest: det F = ", "lifting.slip", "time.step"})
      EXPECT_NE(std::string(failure.what()).find(part), std::string::npos) << failure.what();
  }
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
