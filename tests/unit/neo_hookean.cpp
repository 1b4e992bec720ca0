#include "mech_solver/constitutive/neo_hookean.h"

#include "tests/unit/constitutive_checks.h"

using namespace heartbus::mech;
using namespace heartbus::mech::checks;

namespace {
const NeoHookean soft{12e3, 50e3};
}

TEST(NeoHookean, StressIsTheDerivativeOfTheEnergy) { expect_stress_is_derivative_of_energy(soft); }

TEST(NeoHookean, TangentIsTheDerivativeOfTheStress) { expect_tangent_is_derivative_of_stress(soft); }

TEST(NeoHookean, RotationsCostNothing) { expect_rotation_invariance(soft, 50e3); }

TEST(NeoHookean, LanesGiveTheNumbersOfOne) { expect_lanes_equal_double(soft); }

TEST(NeoHookean, SmallStrainModuliAreThoseOfLinearElasticity) {
  Symmetric<double> S;
  Tangent<double> D;
  soft.stress_and_tangent(Symmetric<double>{1, 1, 1, 0, 0, 0}, 1.0, soft.volumetric(1.0), S, D);
  EXPECT_NEAR(D[0][0], 50e3 + 4.0 / 3.0 * 12e3, 1e-9); // kappa + 4 mu / 3 = 66 kPa
  EXPECT_NEAR(D[0][1], 50e3 - 2.0 / 3.0 * 12e3, 1e-9);
  EXPECT_NEAR(D[3][3], 12e3, 1e-9);
}
