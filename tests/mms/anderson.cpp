#include "common/nonlinear/anderson.h"
#include "common/nonlinear/iterate_extrapolation.h"

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

namespace {

/// Iterate k of the step to time t, which the parabola in t describes.
Vector iterate(int k, double t) {
  Vector x(n);
  for (unsigned i = 0; i < n; ++i)
    x[i] = 1 + i * t + (1 + 0.1 * k) * t * t + k * (2 - i * t);
  return x;
}

/// How far the predictions of a step's iterates are from what comes, given the steps before.
double largest_miss(const fem::IterateExtrapolation<Vector> &moves, int n_iterates, double t) {
  double miss = 0;
  Vector x = iterate(n_iterates - 1, t); // the extrapolated states, here exact
  for (int k = 0; k < n_iterates; ++k) {
    moves.predict(k, x);
    x -= iterate(k, t);
    miss = std::max(miss, x.linfty_norm());
    x = iterate(k, t);
  }
  return miss;
}

void take_step(fem::IterateExtrapolation<Vector> &moves, int n_iterates, double t) {
  for (int k = 0; k < n_iterates; ++k)
    moves.record(k, iterate(k, t));
  moves.commit();
}

} // namespace

TEST(IterateExtrapolation, IteratesThatFollowParabolasAreForeseenAfterThreeSteps) {
  fem::IterateExtrapolation<Vector> moves;
  double before = largest_miss(moves, 3, 0.1);
  for (int step = 1; step <= 3; ++step) {
    take_step(moves, 3, 0.1 * step);
    const double now = largest_miss(moves, 3, 0.1 * (step + 1));
    EXPECT_LT(now, 0.3 * before) << "after step " << step;
    before = now;
  }
  EXPECT_LT(before, 1e-13);
}

TEST(IterateExtrapolation, AnIterateThatTheStepBeforeDidNotHaveIsTheLastOne) {
  fem::IterateExtrapolation<Vector> moves;
  take_step(moves, 3, 0.1);
  take_step(moves, 2, 0.2);
  Vector x = iterate(1, 0.3);
  moves.predict(2, x);
  x -= iterate(1, 0.3);
  EXPECT_EQ(x.linfty_norm(), 0);
}

TEST(IterateExtrapolation, OneIterateAStepAndForgettingLeaveNothing) {
  fem::IterateExtrapolation<Vector> moves;
  const double unknown = largest_miss(moves, 2, 0.3);
  take_step(moves, 2, 0.1);
  EXPECT_LT(largest_miss(moves, 2, 0.3), unknown);
  moves.forget();
  EXPECT_EQ(largest_miss(moves, 2, 0.3), unknown);
  take_step(moves, 2, 0.1);
  take_step(moves, 1, 0.2);
  EXPECT_EQ(largest_miss(moves, 2, 0.3), unknown);
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
