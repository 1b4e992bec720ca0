#include "mech_solver/constitutive/saint_venant_kirchhoff.h"

#include "tests/unit/constitutive_checks.h"

using namespace heartbus::mech;
using namespace heartbus::mech::checks;

namespace {
const SaintVenantKirchhoff beam{12e3, 50e3};
}

TEST(SaintVenantKirchhoff, StressIsTheDerivativeOfTheEnergy) { expect_stress_is_derivative_of_energy(beam); }

TEST(SaintVenantKirchhoff, TangentIsTheDerivativeOfTheStress) { expect_tangent_is_derivative_of_stress(beam); }

TEST(SaintVenantKirchhoff, RotationsCostNothing) { expect_rotation_invariance(beam, 50e3); }

TEST(SaintVenantKirchhoff, LanesGiveTheNumbersOfOne) { expect_lanes_equal_double(beam); }

TEST(SaintVenantKirchhoff, SmallStrainModuliAreThoseOfLinearElasticity) {
  Symmetric<double> S;
  Tangent<double> D;
  beam.stress_and_tangent(Symmetric<double>{1, 1, 1, 0, 0, 0}, 1.0, beam.volumetric(1.0), S, D);
  EXPECT_NEAR(D[0][0], 50e3 + 4.0 / 3.0 * 12e3, 1e-9);
  EXPECT_NEAR(D[0][1], 50e3 - 2.0 / 3.0 * 12e3, 1e-9);
  EXPECT_NEAR(D[3][3], 12e3, 1e-9);
}
