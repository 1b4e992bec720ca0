#include "common/bus/doorbell.h"

#include "mpi_test_main.h"

#include <thread>

using heartbus::bus::Doorbells;
using namespace std::chrono_literals;

namespace {

constexpr int sleeper = 0, late = 1, early = 2;

/// Rank 0 goes to sleep; first rank 2 rings, then rank 1. Returns how often rank 0's bell has rung when it wakes (-1 on
/// the other ranks).
int rings_until_awake(Doorbells::Ranks callers) {
  Doorbells bells(MPI_COMM_WORLD);
  int rank = 0, rings = -1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank == sleeper) {
    bells.sleep(0, callers, 20s);
    rings = bells.rings();
  } else {
    std::this_thread::sleep_for(rank == early ? 200ms : 400ms); // the sleeper lies down meanwhile
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
  EXPECT_EQ(rings_until_awake(Doorbells::only(early)), rank == sleeper ? 1 : -1);
  EXPECT_EQ(rings_until_awake(Doorbells::only(late)), rank == sleeper ? 2 : -1);
}

TEST_F(Doorbell, WhoSleepsForSeveralIsWokenByTheLast) {
  EXPECT_EQ(rings_until_awake(Doorbells::only(early) | Doorbells::only(late)), rank == sleeper ? 2 : -1);
}

TEST_F(Doorbell, AnybodyWakesWhoSleepsForAnybody) {
  EXPECT_EQ(rings_until_awake(Doorbells::anybody), rank == sleeper ? 1 : -1);
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
