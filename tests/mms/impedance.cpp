#include "body.h"
#include "mpi_test_main.h"

using namespace heartbus;
using namespace heartbus::mech;

namespace {

/// An elastic column of 10 mm, its top the interface.
struct Column : Body {
  Column(unsigned layers, double width = 5e-3)
      : Body(relabelled(geometry::make_box({0, 0, 0}, {width, width, 10e-3}, {2, 1, layers}), "z_high", "interface"),
             parameters()) {}
  static Parameters parameters() {
    Parameters parameters = soft_neo_hookean();
    parameters.rollers = {"x_low", "x_high", "y_low", "y_high"};
    parameters.pericardium = {{"z_low"}, 1e4, 0, 2e4, 0};
    return parameters;
  }
};

/// Pressure over wall velocity in the first step from rest.
double column_impedance(unsigned layers) {
  const double dt = 2e-4, pressure = 1;
  Column body(layers);
  body.problem.interface_pressure = pressure;
  fem::Vector d = body.space.make_vector(3);
  body.problem.solve_dynamic(dt, d);
  const auto on = body.space.nodes_on("interface");
  double displacement = 0;
  for (unsigned node = 0; node < body.space.n_owned_nodes(); ++node)
    if (on[node])
      displacement = std::min(displacement, d.begin()[3 * node + 2]);
  return pressure * dt / -dealii::Utilities::MPI::min(displacement, MPI_COMM_WORLD);
}

/// With blood that yields to a force by so much of what the wall does.
double alpha_limit(Column &column, double dt, double share = 0) {
  InterfaceWall wall(column.problem);
  interface::AlphaLimit limit(wall);
  limit.begin(dt, 0);
  for (int probe = 0; probe < 12; ++probe) {
    fem::Vector wall_velocity = column.space.make_vector(3);
    column.problem.solve_tangent(wall_velocity, limit.force());
    wall_velocity *= -share / dt;
    limit.add(wall_velocity);
  }
  return limit.value();
}

} // namespace

TEST(Impedance, StepImpedanceOfAColumnIsThatOfTheOneDimensionalMatrices) {
  // 1 / (dt A^{-1})_00 with A = M/dt^2 + C/dt + K of linear elements, E' = 66 kPa, rho = 1000, dt = 0.2 ms, 10 mm.
  EXPECT_NEAR(column_impedance(3), 9442, 1);
  EXPECT_NEAR(column_impedance(6), 8473, 1);
}

TEST(Impedance, LimitOfAlphaIsTwiceTheImpedanceOfTheOneDimensionalMatrices) {
  Column column(3, 3e-3); // slender: it tilts less easily than it moves
  EXPECT_NEAR(alpha_limit(column, 2e-4), 2 * 9442, 10);
  EXPECT_NEAR(alpha_limit(column, 1e-4), 2 * 12593, 10);
}

TEST(Impedance, BloodThatYieldsAllowsALargerAlpha) {
  Column column(3);
  EXPECT_NEAR(alpha_limit(column, 2e-4, 0.2), 2 * 9442 / 0.8, 20);
  EXPECT_GT(alpha_limit(column, 2e-4, 1.1), 1e6) << "no limit";
}

TEST(Impedance, AWideInterfaceYieldsMoreByTiltingThanAsAWhole) {
  Column wide(3, 20e-3);
  EXPECT_LT(alpha_limit(wide, 2e-4), 2 * 0.9 * 9442);
}

TEST(Impedance, NoMotionOfTheInterfaceHasLessThanTheSmallestImpedance) {
  Column column(3);
  const double dt = 2e-4, smallest = alpha_limit(column, dt) / 2;
  LoadedSurface surface(column.space, "interface");
  double found = 1e300;
  for (int motion = 0; motion < 20; ++motion) {
    fem::Vector x = column.interpolate([&](const geometry::Point3 &p) {
      return Vec3<double>{std::sin(motion * 2000 * p[1]), std::cos(motion * 900 * p[0]),
                          std::cos(motion * 700 * p[0] + motion % 3)};
    });
    fem::zero_constrained(x, column.problem.constrained());
    x.update_ghost_values();
    fem::Vector Mx = column.space.make_vector(3), w(Mx);
    surface.apply_mass(column.problem.past[0], x, Mx);
    Mx.zero_out_ghost_values();
    fem::zero_constrained(Mx, column.problem.constrained());
    column.problem.solve_tangent(w, Mx);
    found = std::min(found, dt * (x * Mx) / (Mx * w));
  }
  EXPECT_GT(found, 0.99 * smallest);
  EXPECT_LT(found, 1.5 * smallest);
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
