#include "common/bus/placement.h"

#ifdef __linux__
#include <sched.h>
#endif

namespace heartbus::bus {

#ifdef __linux__

namespace {

/// Which core the ranks of a node share may be taken by the k-th of them; -1 when their launcher gave them others.
int shared_core(MPI_Comm node, const cpu_set_t &own, int k) {
  cpu_set_t shared;
  MPI_Allreduce(&own, &shared, sizeof(own), MPI_BYTE, MPI_BAND, node);
  if (!CPU_EQUAL(&own, &shared))
    return -1;
  for (int core = 0; core < CPU_SETSIZE; ++core)
    if (CPU_ISSET(core, &shared) && k-- == 0)
      return core;
  return -1;
}

} // namespace

int keep_to_own_core(MPI_Comm participant) {
  MPI_Comm node;
  MPI_Comm_split_type(participant, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
  int n_ranks, rank;
  MPI_Comm_size(node, &n_ranks);
  MPI_Comm_rank(node, &rank);
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  sched_getaffinity(0, sizeof(allowed), &allowed);
  const int n_cores = CPU_COUNT(&allowed), core = shared_core(node, allowed, n_cores > 0 ? rank % n_cores : 0);
  MPI_Comm_free(&node);
  if (n_cores < 2 || n_ranks % n_cores != 0 || core < 0)
    return -1;
  CPU_ZERO(&allowed);
  CPU_SET(core, &allowed);
  return sched_setaffinity(0, sizeof(allowed), &allowed) == 0 ? core : -1;
}

#else

int keep_to_own_core(MPI_Comm) { return -1; }

#endif

} // namespace heartbus::bus
