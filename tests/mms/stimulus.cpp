#include "ep_solver/stimulus.h"
#include "common/base/failure.h"
#include "mpi_test_main.h"

using namespace heartbus;

namespace {

/// A point on each rank, 1 mm from one to the next.
std::vector<geometry::Point3> points() {
  int rank;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return {{1e-3 * rank, 0, 0}};
}

ep::StimulusParameters around_the_first_point() {
  ep::StimulusParameters p;
  p.sites = {{"ball", {0, 0, 0}, 0.5e-3}};
  return p;
}

} // namespace

/// Two beats of 800 ms, the pulse of 3 ms shorter or longer than a step and ending within one.
TEST(Stimulus, StepsOfAnyLengthDeliverTheWholePulse) {
  const ep::StimulusParameters parameters = around_the_first_point();
  const ep::Stimulus stimulus(parameters, {{0, 0, 0}}, MPI_COMM_SELF);
  for (const double dt : {0.05e-3, 0.1e-3, 0.2e-3, 0.4e-3, 0.8e-3, 5e-3}) {
    double delivered[2] = {};
    for (int n = 0; n * dt < 1.6 - 1e-9; ++n) {
      double current = 0;
      stimulus.add(n * dt, (n + 1) * dt, 1, &current);
      EXPECT_LE(current, parameters.amplitude * (1 + 1e-12));
      delivered[n * dt < 0.8 - 1e-9 ? 0 : 1] += dt * current;
    }
    EXPECT_NEAR(delivered[0] + delivered[1], 2 * 3e-3 * parameters.amplitude, 1e-12) << dt;
    EXPECT_GE(delivered[0], 3e-3 * parameters.amplitude - 1e-12) << dt;
  }
}

TEST(Stimulus, StepsThatAPulseFillsGetItsWholeCurrent) {
  const ep::Stimulus stimulus(around_the_first_point(), {{0, 0, 0}}, MPI_COMM_SELF);
  for (int n = 0; n < 4000; ++n)
    EXPECT_EQ(stimulus.share(n * 2e-4, (n + 1) * 2e-4), n < 15 ? 1 : 0) << n; // not even round-off
  EXPECT_DOUBLE_EQ(stimulus.share(2.8e-3, 3.2e-3), 0.5);
  EXPECT_NEAR(stimulus.share(799.5e-3, 800.5e-3), 0.5, 1e-12);
}

TEST(Stimulus, SiteThatReachesNoNodeOfAnyRankIsRefusedOnAll) {
  ep::StimulusParameters parameters = around_the_first_point();
  EXPECT_NO_THROW(ep::Stimulus(parameters, points(), MPI_COMM_WORLD)); // one rank has the node
  parameters.sites.push_back({"cube", {0, 3e-3, 0}, 2e-3});
  try {
    ep::Stimulus(parameters, points(), MPI_COMM_WORLD);
    FAIL();
  } catch (const Failure &failure) {
    EXPECT_EQ(failure.code(), ExitCode::scene);
    for (const std::string part : {"site 2, a cube", "[0, 3, 0] mm", "nearest is 3 mm"})
      EXPECT_NE(std::string(failure.what()).find(part), std::string::npos) << failure.what();
  }
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
