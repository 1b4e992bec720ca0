#include "common/bus/doorbell.h"

#include "mpi_test_main.h"

#include <thread>

using heartbus::bus::Doorbells;
using namespace std::chrono_literals;

namespace {

constexpr int sleeper = 0, awaited = 1, other = 2;

/// Three participants of one rank each. Rank 0 goes to sleep for rank 1; first rank 2 rings, then rank 1.
/// Returns how often rank 0's bell has rung when it wakes (-1 on the other ranks).
int rings_slept_through(int coupler) {
  Doorbells bells(MPI_COMM_WORLD, {sleeper, awaited, other}, coupler);
  int rank = 0, rings = -1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank == sleeper) {
    bells.sleep(0, awaited, 20s);
    rings = bells.rings();
  } else {
    std::this_thread::sleep_for(rank == other ? 200ms : 400ms); // the sleeper lies down meanwhile
    bells.ring(sleeper);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  bells.free();
  return rings;
}

struct Doorbell : testing::Test {
  int rank = 0, n_ranks = 0;
  void SetUp() override {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &n_ranks);
    if (n_ranks < 3)
      GTEST_SKIP() << "three ranks are needed";
  }
};

} // namespace

TEST_F(Doorbell, WhoSleepsIsWokenByWhomItWaitsForOnly) {
  const int rings = rings_slept_through(Doorbells::anybody);
  EXPECT_EQ(rings, rank == sleeper ? 2 : -1);
}

TEST_F(Doorbell, TheCouplerIsHeardByAll) {
  const int rings = rings_slept_through(other);
  EXPECT_EQ(rings, rank == sleeper ? 1 : -1);
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
