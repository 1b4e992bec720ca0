#include "common/fem/anderson.h"

#include "mpi_test_main.h"

#include <deal.II/lac/vector.h>

using namespace heartbus;

namespace {

using Vector = dealii::Vector<double>;
constexpr unsigned n = 5;

/// A map whose plain iteration diverges.
Vector G(const Vector &x) {
  Vector y(n);
  for (unsigned i = 0; i < n; ++i) {
    y[i] = 1.0 + i;
    for (unsigned j = 0; j < n; ++j)
      y[i] += (i == j ? -1.5 - 0.2 * i : 0.3 / (1 + i + 2 * j)) * x[j];
  }
  return y;
}

double residual_after(unsigned evaluations, unsigned depth) {
  fem::Anderson<Vector> anderson(depth);
  Vector x(n);
  for (unsigned k = 0; k < evaluations; ++k)
    x = anderson.next(x, G(x));
  Vector r = G(x);
  r -= x;
  return r.l2_norm();
}

} // namespace

TEST(Anderson, ALinearMapInNDimensionsNeedsNPlusOneEvaluations) {
  EXPECT_LT(residual_after(n + 1, 10), 1e-10);
  EXPECT_GT(residual_after(n, 10), 1e-5);
}

TEST(Anderson, DepthZeroIsThePlainIteration) { EXPECT_GT(residual_after(20, 0), 1e2); }

TEST(Anderson, AStepBeyondTheSolutionDoesNoHarm) { EXPECT_LT(residual_after(n + 4, 10), 1e-10); }

TEST(Anderson, ARestartForgetsAnotherMap) {
  fem::Anderson<Vector> anderson(10);
  Vector x(n), y(n);
  y = 1;
  anderson.next(x, y);
  anderson.restart();
  x = anderson.next(x, y);
  EXPECT_EQ(x[0], 1);
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
