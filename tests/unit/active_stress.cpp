#include "mech_solver/active/active_stress.h"

#include "tests/unit/constitutive_checks.h"

using namespace heartbus::mech;
using namespace heartbus::mech::checks;

namespace {

/// T O / lambda F H with f0 the first axis, n0 the third; for nu = 0 and long fibres as the paper prints it.
Matrix printed(double T, double nu, const Matrix &F, double overlap = 1) {
  Matrix P{};
  double I4 = 0;
  for (unsigned i = 0; i < 3; ++i)
    I4 += (1 - nu) * F[i][0] * F[i][0] + nu * F[i][2] * F[i][2];
  for (const unsigned axis : {0u, 2u})
    for (unsigned i = 0; i < 3; ++i)
      P[i][axis] = (axis == 0 ? 1 - nu : nu) * T * overlap * F[i][axis] / std::sqrt(I4);
  return P;
}

constexpr ActiveFibres long_fibres{10}, short_fibres{1.45};

void active_only(double T, double nu, const Matrix &F, Symmetric<double> &S, Tangent<double> &D,
                 const ActiveFibres &fibres = long_fibres) {
  S = {};
  D = {};
  add_active_stress(T, nu, fibres, right_cauchy_green(F), S, D);
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
    add_active_stress(3e4, nu, long_fibres, right_cauchy_green(F), S_alone);
    EXPECT_EQ(S, S_alone);
  }
}

/// Of long fibres, and of short ones, whose overlap changes with their length.
TEST(ActiveStress, TangentIsTheDerivativeOfTheStress) {
  std::mt19937 generator(6);
  for (unsigned sample = 0; sample < 10; ++sample) {
    const double nu = 0.1 * (sample / 2);
    const ActiveFibres &fibres = sample % 2 ? short_fibres : long_fibres;
    const Matrix F = random_deformation(generator), H = random_matrix(generator, 1.0);
    const auto stress = [&](const Matrix &G) {
      Symmetric<double> S{};
      add_active_stress(3e4, nu, fibres, right_cauchy_green(G), S);
      return Matrix(G * full(S));
    };
    const Matrix exact = stress_increment(
        [&](const Matrix &G, Symmetric<double> &S, Tangent<double> &D) { active_only(3e4, nu, G, S, D, fibres); }, F,
        H);
    expect_second_order([&](double h) {
      const Matrix difference = (1 / (2 * h)) * Matrix(stress(F + h * H) - stress(F - h * H));
      return norm(difference - exact) / norm(exact);
    });
  }
}

/// Filaments of the RDQ18 model: none overlap in sarcomeres of 1.2 um, and the two parts meet at 1.65 um.
TEST(ActiveStress, OverlapFallsToZeroBelowTheTrainedLengths) {
  double slope;
  EXPECT_EQ(overlap(1.1, slope), 0);
  EXPECT_EQ(slope, 0);
  EXPECT_NEAR(overlap(1.2, slope), 0, 1e-15);
  EXPECT_NEAR(overlap(1.65 - 1e-12, slope), 0.9 / 0.95, 1e-11);
  EXPECT_NEAR(slope, 2 / 0.95, 1e-14);
  EXPECT_NEAR(overlap(1.65 + 1e-12, slope), 0.9 / 0.95, 1e-11);
  EXPECT_NEAR(overlap(1.7 - 1e-12, slope), 1, 1e-11);
  EXPECT_EQ(overlap(1.7, slope), 1);
  EXPECT_EQ(overlap(2.2, slope), 1);
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
    add_active_stress(2e4, 0.0, long_fibres, right_cauchy_green(F), S);
    EXPECT_DOUBLE_EQ(F[0][0] * S[0], 2e4);
  }
}
