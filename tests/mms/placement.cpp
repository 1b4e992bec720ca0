// On 2 ranks: as many as a small machine has cores.
#include "common/bus/placement.h"

#include "mpi_test_main.h"

#include <sched.h>

namespace {

cpu_set_t allowed_cores() {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  sched_getaffinity(0, sizeof(cores), &cores);
  return cores;
}

/// Whatever a test does to this process ends with it.
struct Placement : testing::Test {
  const cpu_set_t before = allowed_cores();
  int n_ranks = 0, rank = 0;
  Placement() {
    MPI_Comm_size(MPI_COMM_WORLD, &n_ranks);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  }
  ~Placement() override { sched_setaffinity(0, sizeof(before), &before); }
};

} // namespace

TEST_F(Placement, RanksThatFillTheCoresKeepToOneEach) {
  const int n_cores = CPU_COUNT(&before), core = heartbus::bus::keep_to_own_core(MPI_COMM_WORLD);
  const cpu_set_t after = allowed_cores();
  if (n_cores == 1 || n_ranks % n_cores != 0) {
    EXPECT_EQ(core, -1);
    EXPECT_TRUE(CPU_EQUAL(&before, &after));
    return;
  }
  EXPECT_EQ(CPU_COUNT(&after), 1);
  EXPECT_TRUE(CPU_ISSET(core, &after));
  int used[CPU_SETSIZE] = {}, all[CPU_SETSIZE];
  used[core] = 1;
  MPI_Allreduce(used, all, CPU_SETSIZE, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
  for (int c = 0; c < CPU_SETSIZE; ++c)
    EXPECT_EQ(all[c], CPU_ISSET(c, &before) ? n_ranks / n_cores : 0) << "core " << c;
}

TEST_F(Placement, CoresThatTheLauncherChoseRemain) {
  int nth = rank % CPU_COUNT(&before), core = 0;
  while (!CPU_ISSET(core, &before) || nth-- > 0)
    ++core;
  cpu_set_t chosen;
  CPU_ZERO(&chosen);
  CPU_SET(core, &chosen);
  sched_setaffinity(0, sizeof(chosen), &chosen);
  heartbus::bus::keep_to_own_core(MPI_COMM_WORLD);
  const cpu_set_t after = allowed_cores();
  EXPECT_TRUE(CPU_EQUAL(&chosen, &after));
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
