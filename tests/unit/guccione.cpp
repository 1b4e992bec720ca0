#include "mech_solver/constitutive/guccione.h"

#include "tests/unit/constitutive_checks.h"

using namespace heartbus::mech;
using namespace heartbus::mech::checks;

TEST(Guccione, StressIsTheDerivativeOfTheEnergy) { expect_stress_is_derivative_of_energy(Guccione()); }

TEST(Guccione, TangentIsTheDerivativeOfTheStress) { expect_tangent_is_derivative_of_stress(Guccione()); }

TEST(Guccione, RotationsCostNothing) { expect_rotation_invariance(Guccione(), 50e3); }

TEST(Guccione, LanesGiveTheNumbersOfOne) { expect_lanes_equal_double(Guccione()); }

TEST(Guccione, SmallStrainModuliAreTheCoefficientsTimesC) {
  const Guccione law;
  Symmetric<double> S;
  Tangent<double> D;
  law.stress_and_tangent(Symmetric<double>{1, 1, 1, 0, 0, 0}, 1.0, law.volumetric(1.0), S, D);
  EXPECT_NEAR(D[0][0], 880 * 8 + 50e3, 1e-9);
  EXPECT_NEAR(D[0][1], 50e3, 1e-9);
  EXPECT_NEAR(D[3][3], 0.5 * 880 * 12, 1e-9); // the shear modulus c a_fs / 2 = 5.3 kPa
  EXPECT_NEAR(D[5][5], 0.5 * 880 * 3, 1e-9);
}

TEST(Guccione, UniaxialStretchAlongTheFibreHasTheEnergyWrittenByHand) {
  Matrix F = heartbus::fem::identity<double>();
  F[0][0] = 1.2;
  const double E = 0.5 * (1.44 - 1);
  EXPECT_NEAR(Guccione().energy(F), 440 * (std::exp(8 * E * E) - 1) + 25e3 * 0.2 * std::log(1.2), 1e-9);
}

TEST(Guccione, ShearStrainCountsTwiceInTheExponent) {
  Matrix F = heartbus::fem::identity<double>();
  F[0][1] = 0.3; // E_fs = 0.15, E_ss = 0.045
  EXPECT_NEAR(Guccione().exponent(right_cauchy_green(F), 1.0), 2 * 12 * 0.15 * 0.15 + 6 * 0.045 * 0.045, 1e-14);
}
