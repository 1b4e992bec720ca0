#include "common/nonlinear/newton.h"

#include <algorithm>
#include <gtest/gtest.h>

using namespace heartbus;
using namespace heartbus::fem;

namespace {

/// One number that behaves like a distributed vector.
struct Number {
  double x = 0;
  Number &operator=(double value) {
    x = value;
    return *this;
  }
  void add(double a, const Number &b) { x += a * b.x; }
  void swap(Number &b) { std::swap(x, b.x); }
};

/// atan(x) = 0: plain Newton diverges from |x| > 1.39; states beyond `limit` are invalid.
struct Arctangent {
  double limit = 1e10;
  double slope = 0; ///< of the tangent; 0: none yet
  unsigned tangents = 0;
  ResidualSize residual(const Number &x, Number &r) {
    r.x = std::atan(x.x);
    return {std::abs(x.x) < limit, std::abs(r.x), 1};
  }
  bool has_tangent() const { return slope != 0; }
  void linearise(const Number &x) {
    slope = 1 / (1 + x.x * x.x);
    ++tangents;
  }
  unsigned solve(Number &dx, const Number &r) {
    dx.x = -r.x / slope;
    return 2;
  }
  double size(const Number &dx) const { return std::abs(dx.x); }
  void refuse() const { throw Failure(ExitCode::not_finite, "beyond the limit"); }
};

/// x^2 + 1 = 0 has no solution.
struct Hopeless : Arctangent {
  ResidualSize residual(const Number &x, Number &r) {
    r.x = x.x * x.x + 1;
    return {true, std::abs(r.x), 1};
  }
  void linearise(const Number &x) { slope = 2 * x.x; }
};

/// x + 1 = 0 where only x >= 0 is allowed.
struct Bordered : Arctangent {
  ResidualSize residual(const Number &x, Number &r) {
    last = x.x;
    r.x = x.x + 1;
    return {x.x >= 0, std::abs(r.x), 1};
  }
  void linearise(const Number &) { slope = 1; }
  void refuse() const { throw Failure(ExitCode::not_finite, last < 0 ? "beyond the border" : "valid"); }
  double last = 0;
};

} // namespace

TEST(Newton, SaysWhatIsWrongWithTheStatesThatStopIt) {
  Bordered problem;
  Number x{0};
  try {
    newton("the bordered equation", problem, x, NewtonSettings());
    FAIL() << "went beyond the border";
  } catch (const Failure &failure) {
    EXPECT_EQ(failure.code(), ExitCode::not_finite) << failure.what();
    EXPECT_STREQ(failure.what(), "beyond the border");
  }
}

TEST(Newton, BacktracksWhereTheFullStepDiverges) {
  Arctangent problem;
  Number x{5};
  const NewtonStatistics statistics = newton("test", problem, x, NewtonSettings());
  EXPECT_LT(std::abs(x.x), 1e-8);
  EXPECT_EQ(statistics.linear_iterations, 2 * statistics.iterations);
  EXPECT_LE(statistics.error, 1e-8);
}

TEST(Newton, NeverAcceptsAnInvalidState) {
  Arctangent problem;
  problem.limit = 2; // the full step from 1.9 leads to -3.1
  Number x{1.9};
  EXPECT_NO_THROW(newton("test", problem, x, NewtonSettings()));
  EXPECT_LT(std::abs(x.x), 1e-8);
  x.x = 2.5;
  EXPECT_THROW(newton("test", problem, x, NewtonSettings()), Failure) << "an invalid start";
  const Number valid{1.9};
  EXPECT_NO_THROW(newton("test", problem, x, NewtonSettings(), &valid));
  EXPECT_LT(std::abs(x.x), 1e-8);
}

TEST(Newton, KeepsATangentThatContracts) {
  Arctangent problem;
  Number x{0.3};
  problem.slope = 0.97;
  const NewtonStatistics statistics = newton("test", problem, x, NewtonSettings());
  EXPECT_EQ(statistics.tangents, 0u);
  EXPECT_LT(std::abs(x.x), 1e-8);
  EXPECT_LT(std::abs(x.x), 2 * statistics.error) << "what is left is what was estimated";
  EXPECT_GT(std::abs(x.x), statistics.error / 2);
}

TEST(Newton, ReplacesATangentThatDoesNot) {
  Arctangent problem;
  Number x{0.3};
  problem.slope = 3; // contracts by a third
  const NewtonStatistics statistics = newton("test", problem, x, NewtonSettings());
  EXPECT_GT(statistics.tangents, 0u);
  EXPECT_LE(statistics.iterations, 10u); // kept, it would take 45
}

TEST(Newton, LimitsTheUpdate) {
  Arctangent problem;
  Number x{1};
  NewtonSettings settings;
  settings.largest_update = 0.1;
  EXPECT_GE(newton("test", problem, x, settings).iterations, 10u);
}

TEST(Newton, SaysWhereAndWhyItStopped) {
  Hopeless problem;
  Number x{0.5};
  try {
    newton("the hopeless equation", problem, x, NewtonSettings());
    FAIL() << "found a root of x^2 + 1";
  } catch (const Failure &failure) {
    EXPECT_EQ(failure.code(), ExitCode::not_converged);
    EXPECT_NE(std::string(failure.what()).find("the hopeless equation"), std::string::npos);
  }
}

TEST(Newton, DoesNothingAtASolution) {
  Arctangent problem;
  Number x{0};
  EXPECT_EQ(newton("test", problem, x, NewtonSettings()).iterations, 0u);
  EXPECT_EQ(problem.tangents, 0u);
}
