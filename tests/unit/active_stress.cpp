#include "mech_solver/active/active_stress.h"

#include "tests/unit/constitutive_checks.h"

using namespace heartbus::mech;
using namespace heartbus::mech::checks;

namespace {

/// T [(1 - nu) F f0 x f0 / sqrt(I4f) + nu F n0 x n0 / sqrt(I4n)] with f0 the first axis, n0 the third; nu = 0 as the
/// paper prints it.
Matrix printed(double T, double nu, const Matrix &F) {
  Matrix P{};
  for (const unsigned axis : {0u, 2u}) {
    const double I4 = F[0][axis] * F[0][axis] + F[1][axis] * F[1][axis] + F[2][axis] * F[2][axis];
    for (unsigned i = 0; i < 3; ++i)
      P[i][axis] = (axis == 0 ? 1 - nu : nu) * T * F[i][axis] / std::sqrt(I4);
  }
  return P;
}

void active_only(double T, double nu, const Matrix &F, Symmetric<double> &S, Tangent<double> &D) {
  S = {};
  D = {};
  add_active_stress(T, nu, right_cauchy_green(F), S, D);
}

} // namespace

TEST(ActiveStress, IsTheStressOfThePaperAlongFibresAndThatOfBothFamiliesWhereTheyDisperse) {
  std::mt19937 generator(5);
  const Matrix F = random_deformation(generator);
  for (const double nu : {0.0, 0.2, 0.5}) {
    Symmetric<double> S, S_alone{};
    Tangent<double> D;
    active_only(3e4, nu, F, S, D);
    EXPECT_LT(norm(F * full(S) - printed(3e4, nu, F)), 1e-9);
    add_active_stress(3e4, nu, right_cauchy_green(F), S_alone);
    EXPECT_EQ(S, S_alone);
  }
}

TEST(ActiveStress, TangentIsTheDerivativeOfTheStress) {
  std::mt19937 generator(6);
  for (unsigned sample = 0; sample < 5; ++sample) {
    const double nu = 0.1 * sample;
    const Matrix F = random_deformation(generator), H = random_matrix(generator, 1.0);
    const Matrix exact = stress_increment(
        [&](const Matrix &G, Symmetric<double> &S, Tangent<double> &D) { active_only(3e4, nu, G, S, D); }, F, H);
    expect_second_order([&](double h) {
      const Matrix difference = (1 / (2 * h)) * Matrix(printed(3e4, nu, F + h * H) - printed(3e4, nu, F - h * H));
      return norm(difference - exact) / norm(exact);
    });
  }
}

/// Stretched alike along f and n, fibres that lie in both directions pull alike, whatever the azimuth of f.
TEST(ActiveStress, OfFullyDispersedFibresIsIsotropicAlongTheWall) {
  Matrix F = heartbus::fem::identity<double>();
  F[0][0] = F[2][2] = 0.8;
  Symmetric<double> S;
  Tangent<double> D;
  active_only(2e4, 0.5, F, S, D);
  EXPECT_DOUBLE_EQ(S[0], S[2]);
  EXPECT_DOUBLE_EQ(S[0], 0.5 * 2e4 / 0.8);
  EXPECT_DOUBLE_EQ(fibre_stretch_squared(0.5, right_cauchy_green(F)), 0.64);
}

TEST(ActiveStress, NominalFibreStressIsTheTensionAtAnyStretch) {
  for (const double stretch : {0.8, 1.0, 1.3}) {
    Matrix F = heartbus::fem::identity<double>();
    F[0][0] = stretch;
    Symmetric<double> S{};
    add_active_stress(2e4, 0.0, right_cauchy_green(F), S);
    EXPECT_DOUBLE_EQ(F[0][0] * S[0], 2e4);
  }
}
