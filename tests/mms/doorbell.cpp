#include "common/bus/doorbell.h"

#include "mpi_test_main.h"

#include <sched.h>
#include <thread>
#include <vector>

using heartbus::bus::Doorbells;
using namespace std::chrono_literals;

namespace {

constexpr int sleeper = 0, late = 1, early = 2;

std::vector<int> own_cores() {
  cpu_set_t set;
  sched_getaffinity(0, sizeof set, &set);
  std::vector<int> cores;
  for (int core = 0; core < CPU_SETSIZE; ++core)
    if (CPU_ISSET(core, &set))
      cores.push_back(core);
  return cores;
}

void keep_to(int core) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(core, &set);
  sched_setaffinity(0, sizeof set, &set);
}

/// Rank 0 goes to sleep; first rank 2 rings, on the same core if wanted, then, on another, rank 1. Returns how often
/// rank 0's bell has rung when it wakes (-1 on the other ranks).
int rings_until_awake(Doorbells::Ranks callers, bool on_same_core = false) {
  const std::vector<int> cores = own_cores();
  Doorbells bells(MPI_COMM_WORLD);
  int rank = 0, rings = -1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  keep_to(rank == sleeper || (rank == early && on_same_core) ? cores.front() : cores.back());
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
  cpu_set_t all;
  CPU_ZERO(&all);
  for (const int core : cores)
    CPU_SET(core, &all);
  sched_setaffinity(0, sizeof all, &all);
  return rings;
}

struct Doorbell : testing::Test {
  int rank = 0, n_ranks = 0;
  void SetUp() override {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &n_ranks);
    if (n_ranks < 3)
      GTEST_SKIP() << "three ranks are needed";
    if (own_cores().size() < 2)
      GTEST_SKIP() << "two cores are needed";
  }
};

} // namespace

TEST_F(Doorbell, WhoSleepsIsWokenByWhomItWaitsForOnly) {
  EXPECT_EQ(rings_until_awake(Doorbells::only(early)), rank == sleeper ? 1 : -1);
  EXPECT_EQ(rings_until_awake(Doorbells::only(late)), rank == sleeper ? 2 : -1);
}

TEST_F(Doorbell, CanBeWokenByOneItDoesNotWaitFor) {
  Doorbells bells(MPI_COMM_WORLD);
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank == sleeper) {
    EXPECT_TRUE(bells.sleep(0, Doorbells::only(early), 20s));
  } else if (rank == late) {
    std::this_thread::sleep_for(200ms);
    bells.wake(sleeper);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  bells.free();
}

TEST_F(Doorbell, WhoSleepsForSeveralIsWokenByTheLast) {
  EXPECT_EQ(rings_until_awake(Doorbells::only(early) | Doorbells::only(late)), rank == sleeper ? 2 : -1);
}

TEST_F(Doorbell, WhoSleepsForSeveralIsWokenByTheOneOnItsOwnCore) {
  EXPECT_EQ(rings_until_awake(Doorbells::only(early) | Doorbells::only(late), true), rank == sleeper ? 1 : -1);
  EXPECT_EQ(rings_until_awake(Doorbells::only(late), true), rank == sleeper ? 2 : -1);
}

TEST_F(Doorbell, AnybodyWakesWhoSleepsForAnybody) {
  EXPECT_EQ(rings_until_awake(Doorbells::anybody), rank == sleeper ? 1 : -1);
}

TEST(NodeArray, BeginsAtACacheLineForEachRankAndInEachProcess) {
  struct alignas(64) Line {
    int owner = -1;
  };
  heartbus::bus::NodeArray<Line> lines(MPI_COMM_WORLD);
  lines.mine().owner = lines.rank();
  MPI_Barrier(MPI_COMM_WORLD);
  for (int rank = 0; rank < lines.n_ranks(); ++rank) {
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(lines.of(rank)) % alignof(Line), 0u);
    EXPECT_EQ(lines.of(rank)->owner, rank);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  lines.free();
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
