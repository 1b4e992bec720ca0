#include "common/simd/vectorized_math.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace heartbus;
using fem::n_lanes;
using fem::VectorizedDouble;

namespace {

HEARTBUS_SIMD void exponential(const VectorizedDouble *x, VectorizedDouble *y) { *y = fem::exp(*x); }
HEARTBUS_SIMD void logarithm(const VectorizedDouble *x, VectorizedDouble *y) { *y = fem::log(*x); }
HEARTBUS_SIMD void hyperbolic_tangent(const VectorizedDouble *x, VectorizedDouble *y) { *y = fem::tanh(*x); }

/// Largest relative difference from the standard function over [low, high].
template <class Vectorised, class Standard>
double worst(Vectorised vectorised, Standard standard, double low, double high) {
  double error = 0;
  for (int k = 0; k < 20000; ++k) {
    VectorizedDouble x, y;
    for (unsigned i = 0; i < n_lanes; ++i)
      x[i] = low + (high - low) * (k * n_lanes + i) / 160000;
    vectorised(&x, &y);
    for (unsigned i = 0; i < n_lanes; ++i)
      error = std::max(error, std::abs(y[i] - standard(x[i])) / std::abs(standard(x[i])));
  }
  return error;
}

} // namespace

TEST(LanesMath, ExponentialAgreesWithTheStandardLibrary) {
  EXPECT_LT(worst(
                exponential, [](double x) { return std::exp(x); }, -700, 700),
            2e-15);
  EXPECT_LT(worst(
                exponential, [](double x) { return std::exp(x); }, -1, 1),
            1e-15);
}

TEST(LanesMath, LogarithmAgreesWithTheStandardLibrary) {
  EXPECT_LT(worst(
                logarithm, [](double x) { return std::log(x); }, 1e-9, 1e-3),
            2e-15);
  EXPECT_LT(worst(
                logarithm, [](double x) { return std::log(x); }, 1.0001, 1e5),
            2e-15);
}

TEST(LanesMath, HyperbolicTangentAgreesWithTheStandardLibrary) {
  const auto standard = [](double x) { return std::tanh(x); };
  EXPECT_LT(worst(hyperbolic_tangent, standard, -30, -1), 1e-15);
  EXPECT_LT(worst(hyperbolic_tangent, standard, -1.0001, 1), 2e-15);
  EXPECT_LT(worst(hyperbolic_tangent, standard, 1e-12, 1e-8), 1e-15);
  EXPECT_LT(worst(hyperbolic_tangent, standard, 1, 1e4), 1e-15);
}

TEST(LanesMath, NonsenseStaysVisible) {
  const double nan = std::nan("");
  VectorizedDouble x = {nan, -1, 0, 1}, e, l, t;
  exponential(&x, &e);
  logarithm(&x, &l);
  hyperbolic_tangent(&x, &t);
  EXPECT_TRUE(std::isnan(t[0]));
  EXPECT_EQ(t[2], 0);
  EXPECT_TRUE(std::isnan(e[0]));
  EXPECT_TRUE(std::isnan(l[0]));
  EXPECT_TRUE(std::isnan(l[1]));
  EXPECT_TRUE(std::isnan(l[2]));
  EXPECT_EQ(l[3], 0);
}
