#include "mech_solver/constitutive/holzapfel_ogden.h"

#include "tests/unit/constitutive_checks.h"

using namespace heartbus::mech;
using namespace heartbus::mech::checks;

namespace {

/// The Cauchy stress that shears the face of `face` along `direction`, by the amount of shear.
double shear_stress(unsigned face, unsigned direction, double amount) {
  Matrix F = heartbus::fem::identity<double>();
  F[direction][face] = amount;
  const Matrix P = first_piola(HolzapfelOgden(), F); // J = 1: sigma = P F^T
  return P[direction][0] * F[face][0] + P[direction][1] * F[face][1] + P[direction][2] * F[face][2];
}

constexpr unsigned f = 0, s = 1, n = 2;

} // namespace

TEST(HolzapfelOgden, StressIsTheDerivativeOfTheEnergy) { expect_stress_is_derivative_of_energy(HolzapfelOgden()); }

TEST(HolzapfelOgden, TangentIsTheDerivativeOfTheStress) { expect_tangent_is_derivative_of_stress(HolzapfelOgden()); }

TEST(HolzapfelOgden, RotationsCostNothing) { expect_rotation_invariance(HolzapfelOgden(), 50e3); }

TEST(HolzapfelOgden, LanesGiveTheNumbersOfOne) { expect_lanes_equal_double(HolzapfelOgden()); }

/// Section 5 of the article: what shears the face i along j by g has I1 - 3 = g^2, I4i - 1 = g^2, and I8fs = g in the
/// plane of fibres and sheets.
TEST(HolzapfelOgden, SimpleShearHasTheStressesOfTheArticle) {
  const auto matrix = [](double g) { return 59 * g * std::exp(8.023 * g * g); };
  const auto fibres = [](double g) { return 2 * 18472 * g * g * g * std::exp(16.026 * g * g * g * g); };
  const auto sheets = [](double g) { return 2 * 2481 * g * g * g * std::exp(11.120 * g * g * g * g); };
  const auto both = [](double g) { return 216 * g * std::exp(11.436 * g * g); };
  for (const double g : {-0.4, 0.05, 0.2, 0.5}) {
    EXPECT_NEAR(shear_stress(f, s, g), matrix(g) + fibres(g) + both(g), 1e-9);
    EXPECT_NEAR(shear_stress(f, n, g), matrix(g) + fibres(g), 1e-9);
    EXPECT_NEAR(shear_stress(s, f, g), matrix(g) + sheets(g) + both(g), 1e-9);
    EXPECT_NEAR(shear_stress(s, n, g), matrix(g) + sheets(g), 1e-9);
    EXPECT_NEAR(shear_stress(n, f, g), matrix(g), 1e-9);
    EXPECT_NEAR(shear_stress(n, s, g), matrix(g), 1e-9);
  }
}

/// Fibres are stiffest, then sheets, as of pig myocardium: numbers by hand, in kPa.
TEST(HolzapfelOgden, AHalfOfShearTakesSoMuch) {
  EXPECT_NEAR(1e-3 * shear_stress(f, s, 0.5), 14.677, 5e-4);
  EXPECT_NEAR(1e-3 * shear_stress(f, n, 0.5), 12.793, 5e-4);
  EXPECT_NEAR(1e-3 * shear_stress(s, f, 0.5), 3.346, 5e-4);
  EXPECT_NEAR(1e-3 * shear_stress(s, n, 0.5), 1.462, 5e-4);
  EXPECT_NEAR(1e-3 * shear_stress(n, f, 0.5), 0.219, 5e-4);
}

TEST(HolzapfelOgden, FibresAndSheetsBearTensionOnly) {
  const auto isotropic = [](double l) { // along f, with volume kept
    return 59 / (2 * 8.023) * (std::exp(8.023 * (l * l + 2 / l - 3)) - 1);
  };
  Matrix F = heartbus::fem::identity<double>();
  F[0][0] = 0.8;
  F[1][1] = F[2][2] = 1 / std::sqrt(0.8); // sheets are stretched
  EXPECT_NEAR(HolzapfelOgden().energy(F), isotropic(0.8) + 2481 / (2 * 11.12) * (std::exp(11.12 * 0.0625) - 1), 1e-9);
  F[0][0] = 1.2;
  F[1][1] = F[2][2] = 1 / std::sqrt(1.2); // fibres are
  EXPECT_NEAR(HolzapfelOgden().energy(F), isotropic(1.2) + 18472 / (2 * 16.026) * (std::exp(16.026 * 0.1936) - 1),
              1e-9);
}

/// Which stands for the whole law where a solver asks how far a state may go.
TEST(HolzapfelOgden, TheLargestOfItsExponentsIsTold) {
  const HolzapfelOgden law;
  const auto exponent = [&](unsigned i, unsigned j, double value) {
    Matrix F = heartbus::fem::identity<double>();
    F[i][j] = value;
    return law.exponent(right_cauchy_green(F), heartbus::fem::determinant(F));
  };
  EXPECT_NEAR(exponent(0, 0, 1.3), 16.026 * 0.69 * 0.69, 1e-12);                        // fibres
  EXPECT_NEAR(exponent(1, 1, 1.3), 11.120 * 0.69 * 0.69, 1e-12);                        // sheets
  EXPECT_NEAR(exponent(0, 1, 0.4), 11.436 * 0.16, 1e-12);                               // their shear
  EXPECT_NEAR(exponent(2, 2, 0.7), 8.023 * (2.49 * std::pow(0.7, -2. / 3) - 3), 1e-12); // the matrix
}

TEST(HolzapfelOgden, SmallStrainModuliAreThoseOfItsParts) {
  const HolzapfelOgden law;
  Symmetric<double> S;
  Tangent<double> D;
  law.stress_and_tangent(Symmetric<double>{1, 1, 1, 0, 0, 0}, 1.0, law.volumetric(1.0), S, D);
  EXPECT_NEAR(D[0][0], 50e3 + 4.0 / 3.0 * 59 + 4 * 18472, 1e-9); // fibres as in tension
  EXPECT_NEAR(D[1][1], 50e3 + 4.0 / 3.0 * 59 + 4 * 2481, 1e-9);
  EXPECT_NEAR(D[2][2], 50e3 + 4.0 / 3.0 * 59, 1e-9);
  EXPECT_NEAR(D[0][1], 50e3 - 2.0 / 3.0 * 59, 1e-9);
  EXPECT_NEAR(D[3][3], 59 + 216, 1e-9);
  EXPECT_NEAR(D[4][4], 59, 1e-9);
}
