#include "body.h"
#include "mpi_test_main.h"

using namespace heartbus;
using namespace heartbus::mech;

namespace {

/// P(F) + P_act(F, T) for the oblique fibres, by the formula of the paper.
template <class Law>
Matrix total_stress(const Law &law, const Matrix &F, double T) {
  const double f = 1 / std::sqrt(14.0), s = 1 / std::sqrt(10.0);
  Matrix R;
  const Vec3<double> fibre = {f, 2 * f, 3 * f}, sheet = {3 * s, 0, -s};
  const Vec3<double> normal = {fibre[1] * sheet[2] - fibre[2] * sheet[1], fibre[2] * sheet[0] - fibre[0] * sheet[2],
                               fibre[0] * sheet[1] - fibre[1] * sheet[0]};
  for (unsigned i = 0; i < 3; ++i)
    R[i] = {fibre[i], sheet[i], normal[i]};
  Matrix P = first_piola(law, Matrix(F * R)) * fem::transpose(R);
  const Vec3<double> Ff = F * fibre;
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      P[i][j] += T * Ff[i] * fibre[j] / std::sqrt(fem::dot(Ff, Ff));
  return P;
}

MatrixField gradient(const Field &d) {
  return [d](const geometry::Point3 &x) {
    Matrix F = fem::identity<double>();
    const double h = 1e-5;
    for (unsigned j = 0; j < 3; ++j) {
      geometry::Point3 right = x, left = x;
      right[j] += h;
      left[j] -= h;
      for (unsigned i = 0; i < 3; ++i)
        F[i][j] += (d(right)[i] - d(left)[i]) / (2 * h);
    }
    return F;
  };
}

/// -Div P by differences.
Field body_force(const MatrixField &P) {
  return [P](const geometry::Point3 &x) {
    Vec3<double> f{};
    const double h = 1e-3;
    for (unsigned j = 0; j < 3; ++j) {
      geometry::Point3 right = x, left = x;
      right[j] += h;
      left[j] -= h;
      for (unsigned i = 0; i < 3; ++i)
        f[i] -= (P(right)[i][j] - P(left)[i][j]) / (2 * h);
    }
    return f;
  };
}

double active_tension(const geometry::Point3 &x) { return 4e3 * (1 + x[0] * x[2]); }

/// A unit cube.
geometry::Mesh cube(unsigned n, bool tetrahedra) {
  const geometry::Mesh mesh = geometry::make_box({0, 0, 0}, {1, 1, 1}, {n, n, n});
  return tetrahedra ? geometry::make_tetrahedra(mesh) : mesh;
}

/// Guccione with fibres and active tension, held on all sides.
double static_error_held(unsigned n, bool tetrahedra) {
  Parameters parameters = soft_neo_hookean();
  parameters.law = "guccione";
  parameters.active.sarcomere_length = 3; // so long that the tension acts in full, as in `total_stress`
  parameters.fixed = all_sides;
  Body body(cube(n, tetrahedra), parameters);
  const Field d = [](const geometry::Point3 &x) -> Vec3<double> {
    const double s = 0.06 * std::sin(M_PI * x[0]) * std::sin(M_PI * x[1]) * std::sin(M_PI * x[2]);
    return {s, -s * x[0], 0.5 * s * (1 + x[1])};
  };
  const MatrixField F = gradient(d);
  body.add_volume_load(body_force(
      [&](const geometry::Point3 &x) { return total_stress(parameters.guccione, F(x), active_tension(x)); }));
  for (unsigned node = 0; node < body.space.n_owned_nodes(); ++node)
    body.problem.tension.begin()[node] = active_tension(body.space.points()[node]);
  fem::Vector solution = body.space.make_vector(3);
  body.problem.solve_static(solution);
  return body.error(solution, d);
}

/// Neo-Hookean in springs on five sides, with tractions there.
double static_error_in_springs(unsigned n, bool tetrahedra) {
  Parameters parameters = soft_neo_hookean();
  parameters.fixed = {"z_low"};
  parameters.pericardium.labels = {"x_low", "x_high", "y_low", "y_high", "z_high"};
  Body body(cube(n, tetrahedra), parameters);
  const Field d = [](const geometry::Point3 &x) -> Vec3<double> {
    const double s = 0.08 * std::sin(x[2]);
    return {s * std::cos(2 * x[1]), s * x[0] * x[0], 0.5 * s * (1 + std::sin(x[0] + x[1]))};
  };
  const MatrixField F = gradient(d);
  const MatrixField P = [&](const geometry::Point3 &x) { return total_stress(parameters.neo_hookean, F(x), 0); };
  const MatrixField pull = [&](const geometry::Point3 &x) {
    Matrix k{};
    for (unsigned i = 0; i < 3; ++i)
      k[i] = {parameters.pericardium.K_perp * d(x)[i], parameters.pericardium.K_par * d(x)[i], 0};
    return k;
  };
  body.add_volume_load(body_force(P));
  for (const auto &label : parameters.pericardium.labels)
    body.add_surface_load(label, P, pull);
  fem::Vector solution = body.space.make_vector(3);
  body.problem.solve_static(solution);
  return body.error(solution, d);
}

/// d = sin(omega t) B x is in the discrete space: the error is that of time stepping alone.
double dynamic_error(double dt, bool tetrahedra) {
  Parameters parameters = soft_neo_hookean();
  parameters.pericardium.labels = all_sides;
  Body body(cube(2, tetrahedra), parameters);
  Matrix B;
  B[0] = {0.05, 0.02, 0};
  B[1] = {0.03, -0.04, 0.05};
  B[2] = {0, 0.06, 0.02};
  const double omega = 8;
  const auto displacement = [&](double t) -> Field {
    return [&B, s = std::sin(omega * t)](const geometry::Point3 &x) {
      const Vec3<double> y = B * Vec3<double>{x[0], x[1], x[2]};
      return Vec3<double>{s * y[0], s * y[1], s * y[2]};
    };
  };
  ElasticityProblem &problem = body.problem;
  problem.past[0] = body.interpolate(displacement(0));
  problem.past[1] = body.interpolate(displacement(-dt));
  fem::Vector d = problem.past[0];
  const auto &springs = parameters.pericardium;
  for (double t = dt; t < 0.1 + dt / 2; t += dt) {
    const double s = std::sin(omega * t), rate = omega * std::cos(omega * t);
    const Matrix F = fem::identity<double>() + s * B, P = total_stress(parameters.neo_hookean, F, 0);
    const auto pull = [&](const geometry::Point3 &x) {
      const Vec3<double> y = B * Vec3<double>{x[0], x[1], x[2]};
      Matrix k{};
      for (unsigned i = 0; i < 3; ++i)
        k[i] = {(springs.K_perp * s + springs.C_perp * rate) * y[i], (springs.K_par * s + springs.C_par * rate) * y[i],
                0};
      return k;
    };
    problem.load = 0;
    body.add_volume_load([&](const geometry::Point3 &x) {
      const Vec3<double> y = B * Vec3<double>{x[0], x[1], x[2]};
      const double a = -parameters.density * omega * omega * s;
      return Vec3<double>{a * y[0], a * y[1], a * y[2]};
    });
    for (const auto &label : all_sides)
      body.add_surface_load(
          label, [&](const geometry::Point3 &) { return P; }, pull);
    problem.solve_dynamic(dt, d);
    problem.past.push(d);
  }
  return body.error(d, displacement(0.1));
}

} // namespace

TEST(Elasticity, StaticSolutionOfActiveGuccioneConvergesWithSecondOrder) {
  const double coarse = static_error_held(4, false), fine = static_error_held(8, false);
  EXPECT_GT(coarse / fine, 3.5);
  EXPECT_LT(fine, 2e-3);
  const double coarse_tetrahedra = static_error_held(4, true), fine_tetrahedra = static_error_held(8, true);
  EXPECT_GT(coarse_tetrahedra / fine_tetrahedra, 3);
  EXPECT_LT(fine_tetrahedra, 4e-3);
}

TEST(Elasticity, StaticSolutionInSpringsConvergesWithSecondOrder) {
  const double coarse = static_error_in_springs(3, false), fine = static_error_in_springs(6, false);
  EXPECT_GT(coarse / fine, 3.5);
  EXPECT_LT(fine, 1e-3);
  const double coarse_tetrahedra = static_error_in_springs(3, true), fine_tetrahedra = static_error_in_springs(6, true);
  EXPECT_GT(coarse_tetrahedra / fine_tetrahedra, 3);
  EXPECT_LT(fine_tetrahedra, 2e-3);
}

TEST(Elasticity, TimeSteppingConvergesWithFirstOrder) {
  const double coarse = dynamic_error(1e-2, false), fine = dynamic_error(5e-3, false),
               finest = dynamic_error(2.5e-3, false);
  EXPECT_NEAR(std::log2(coarse / fine), 1, 0.25);
  EXPECT_NEAR(std::log2(fine / finest), 1, 0.15);
  EXPECT_NEAR(dynamic_error(5e-3, true), fine, 0.05 * fine); // the motion is linear in space, its error hardly
}

TEST(Elasticity, PressureFollowsTheSurface) {
  // Pressure on three sides of a block on three rollers: F = lambda I, and its Cauchy stress U'(J) is -p.
  Parameters parameters = soft_neo_hookean();
  parameters.rollers = {"x_low", "y_low", "z_low"};
  geometry::Mesh mesh = geometry::make_box({0, 0, 0}, {1e-2, 1e-2, 1e-2}, {3, 2, 2});
  for (const auto &side : {"x_high", "y_high", "z_high"})
    mesh = relabelled(mesh, side, "interface");
  Body body(mesh, parameters);
  const double lambda = 0.9, J = lambda * lambda * lambda;
  body.problem.interface_pressure = -0.5 * parameters.neo_hookean.kappa * (J - 1 + std::log(J) / J);
  fem::Vector d = body.space.make_vector(3);
  const auto statistics = body.problem.solve_static(d);
  EXPECT_LE(statistics.iterations, 7u) << "the tangent of the pressure is wrong";
  for (unsigned i = 0; i < 3 * body.space.n_owned_nodes(); ++i)
    EXPECT_NEAR(d.begin()[i], (lambda - 1) * body.space.points()[i / 3][i % 3], 1e-9);
}

TEST(Elasticity, RigidRotationsAreFree) {
  Parameters parameters = soft_neo_hookean();
  parameters.law = "guccione";
  Body body(geometry::make_box({0, 0, 0}, {1, 1, 1}, {3, 2, 2}), parameters);
  const double c = std::cos(0.7), s = std::sin(0.7);
  const fem::Vector d = body.interpolate([&](const geometry::Point3 &x) {
    return Vec3<double>{(c - 1) * x[0] - s * x[1], s * x[0] + (c - 1) * x[1], 0.3};
  });
  fem::Vector r = body.space.make_vector(3);
  body.problem.solid_forces(d, r);
  EXPECT_LT(r.linfty_norm(), 1e-10 * parameters.guccione.kappa);
}

TEST(Elasticity, StretchAtTheNodesIsThatOfTheFibre) {
  Body body(geometry::make_box({0, 0, 0}, {1, 1, 1}, {3, 2, 2}), soft_neo_hookean());
  const fem::Vector d = body.interpolate([](const geometry::Point3 &x) {
    return Vec3<double>{0.1 * x[0], 0, -0.2 * x[2]};
  });
  fem::Vector stretch = body.space.make_vector(1);
  body.problem.fibre_stretch(d, stretch);
  const double exact = std::sqrt((1.1 * 1.1 * 1 + 4 + 0.8 * 0.8 * 9) / 14);
  for (unsigned node = 0; node < body.space.n_owned_nodes(); ++node)
    EXPECT_NEAR(stretch.begin()[node], exact, 1e-12);
}

TEST(Elasticity, ActiveForcesAreTheDifferenceOfSolidForces) {
  Parameters parameters = soft_neo_hookean();
  parameters.fixed = {"z_low"};
  Body body(geometry::make_box({0, 0, 0}, {1, 1, 1}, {3, 2, 2}), parameters);
  const fem::Vector d = body.interpolate([](const geometry::Point3 &x) {
    return Vec3<double>{0.1 * x[0] * x[1], 0.05 * x[2], -0.2 * x[2] * x[2]};
  });
  fem::Vector passive = body.space.make_vector(3), active = passive, difference = passive;
  body.problem.solid_forces(d, passive);
  for (unsigned node = 0; node < body.space.n_owned_nodes(); ++node)
    body.problem.tension.begin()[node] = active_tension(body.space.points()[node]);
  body.problem.solid_forces(d, active);
  body.problem.active_forces(d, body.problem.tension, difference);
  EXPECT_GT(difference.linfty_norm(), 10);
  active -= passive;
  active -= difference;
  EXPECT_LT(active.linfty_norm(), 1e-10 * difference.linfty_norm());
}

TEST(Elasticity, PassiveRegionsAreNeoHookeanAndDoNotContract) {
  geometry::Mesh mesh = geometry::make_box({0, 0, 0}, {1, 1, 1}, {2, 2, 4});
  mesh.material_names = {"muscle", "ring"};
  mesh.materials.assign(mesh.n_cells(), 0);
  for (unsigned c = 0; c < mesh.n_cells(); ++c)
    mesh.materials[c] = mesh.points[mesh.cells[8 * c]][2] > 0.49;
  Parameters ring = soft_neo_hookean(), muscle = soft_neo_hookean();
  muscle.law = "guccione";
  Parameters both = muscle;
  both.regions["ring"] = {ring, false};
  Body with_ring(mesh, both), ring_only(mesh, ring), muscle_only(mesh, muscle);
  const auto forces = [](Body &body, double T) {
    const fem::Vector d = body.interpolate([](const geometry::Point3 &x) {
      return Vec3<double>{0.1 * x[0] * x[1], 0.05 * x[2], -0.1 * x[2] * x[2]};
    });
    body.problem.tension = T;
    fem::Vector r = body.space.make_vector(3);
    body.problem.solid_forces(d, r);
    return r;
  };
  const fem::Vector mixed = forces(with_ring, 5e3), top = forces(ring_only, 0), bottom = forces(muscle_only, 5e3);
  for (unsigned node = 0; node < with_ring.space.n_owned_nodes(); ++node)
    for (unsigned i = 0; i < 3; ++i)
      if (const double z = with_ring.space.points()[node][2]; std::abs(z - 0.5) > 0.1) {
        EXPECT_NEAR(mixed.begin()[3 * node + i], z > 0.5 ? top.begin()[3 * node + i] : bottom.begin()[3 * node + i],
                    1e-8);
      }
}

TEST(Elasticity, InvertedStartIsRefusedNamingTheCell) {
  Body body(geometry::make_box({0, 0, 0}, {1, 1, 1}, {2, 2, 2}), soft_neo_hookean());
  const fem::Vector d = body.interpolate([](const geometry::Point3 &x) { return Vec3<double>{-1.5 * x[0], 0, 0}; });
  fem::Vector r = body.space.make_vector(3);
  EXPECT_FALSE(body.problem.residual(d, r).valid);
  EXPECT_THROW(body.problem.refuse(), Failure);
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
