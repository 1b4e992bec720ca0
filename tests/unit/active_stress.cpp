#include "mech_solver/active/active_stress.h"

#include "tests/unit/constitutive_checks.h"

using namespace heartbus::mech;
using namespace heartbus::mech::checks;

namespace {

/// T F f0 x f0 / sqrt(I4f) with f0 the first axis, as the paper prints it.
Matrix printed(double T, const Matrix &F) {
  Matrix P{};
  const double I4f = F[0][0] * F[0][0] + F[1][0] * F[1][0] + F[2][0] * F[2][0];
  for (unsigned i = 0; i < 3; ++i)
    P[i][0] = T * F[i][0] / std::sqrt(I4f);
  return P;
}

void active_only(double T, const Matrix &F, Symmetric<double> &S, Tangent<double> &D) {
  S = {};
  D = {};
  add_active_stress(T, right_cauchy_green(F), S, D);
}

} // namespace

TEST(ActiveStress, IsTheStressOfThePaper) {
  std::mt19937 generator(5);
  const Matrix F = random_deformation(generator);
  Symmetric<double> S;
  Tangent<double> D;
  active_only(3e4, F, S, D);
  EXPECT_LT(norm(F * full(S) - printed(3e4, F)), 1e-9);
}

TEST(ActiveStress, TangentIsTheDerivativeOfTheStress) {
  std::mt19937 generator(6);
  for (unsigned sample = 0; sample < 5; ++sample) {
    const Matrix F = random_deformation(generator), H = random_matrix(generator, 1.0);
    const Matrix exact = stress_increment(
        [](const Matrix &G, Symmetric<double> &S, Tangent<double> &D) { active_only(3e4, G, S, D); }, F, H);
    expect_second_order([&](double h) {
      const Matrix difference = (1 / (2 * h)) * Matrix(printed(3e4, F + h * H) - printed(3e4, F - h * H));
      return norm(difference - exact) / norm(exact);
    });
  }
}

TEST(ActiveStress, NominalFibreStressIsTheTensionAtAnyStretch) {
  for (const double stretch : {0.8, 1.0, 1.3}) {
    Matrix F = heartbus::fem::identity<double>();
    F[0][0] = stretch;
    EXPECT_DOUBLE_EQ(F[0][0] * active_stress_ff(2e4, right_cauchy_green(F)), 2e4);
  }
}
