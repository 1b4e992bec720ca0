#include "common/bus/doorbell.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <new>
#include <thread>

#ifdef __linux__
#include <linux/futex.h>
#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

namespace heartbus::bus {

namespace {
constexpr Doorbells::Ranks nobody = Doorbells::Ranks(1) << 63; ///< who never rings

/// A test may pretend that one machine is several nodes.
int pretended_node() {
  const char *node = std::getenv("HEARTBUS_NODE");
  return node ? std::abs(std::atoi(node)) : 0;
}

} // namespace

Doorbells::Doorbells(MPI_Comm everybody) {
  int size;
  MPI_Comm_rank(everybody, &rank_);
  MPI_Comm_size(everybody, &size);
  MPI_Comm machine;
  MPI_Comm_split_type(everybody, MPI_COMM_TYPE_SHARED, rank_, MPI_INFO_NULL, &machine);
  MPI_Comm_split(machine, pretended_node(), rank_, &node_);
  MPI_Comm_free(&machine);
  void *memory;
  MPI_Win_allocate_shared(sizeof(Bell), 1, MPI_INFO_NULL, node_, &memory, &window_);
  mine_ = new (memory) Bell{{0}, {nobody}, {-1}, {{0}, {0}}};

  MPI_Group all, near;
  MPI_Comm_group(everybody, &all);
  MPI_Comm_group(node_, &near);
  bells_.resize(size);
  for (int r = 0; r < size; ++r) {
    int neighbour, unit;
    MPI_Aint length;
    MPI_Group_translate_ranks(all, 1, &r, near, &neighbour);
    if (neighbour == MPI_UNDEFINED)
      continue;
    MPI_Win_shared_query(window_, neighbour, &length, &unit, &memory);
    bells_[r] = static_cast<Bell *>(memory);
  }
  MPI_Group_free(&near);
  MPI_Group_free(&all);
  MPI_Barrier(node_); // nobody rings a bell that its owner has yet to set to zero
}

void Doorbells::free() {
  MPI_Win_free(&window_);
  MPI_Comm_free(&node_);
}

#ifdef __linux__

bool Doorbells::reach_everybody() const { return std::find(bells_.begin(), bells_.end(), nullptr) == bells_.end(); }

bool Doorbells::shares_core(int rank) const { return reach(rank) && bells_[rank]->core == sched_getcpu(); }

bool Doorbells::ring(int rank) const {
  Bell *bell = bells_[rank];
  if (!bell)
    return false;
  bell->rings.fetch_add(1);
  const Ranks others = ~only(rank_), before = bell->missing.fetch_and(others);
  const bool wakes = (before & others) == 0 || (before != nobody && before & ~others && shares_core(rank));
  return wakes && syscall(SYS_futex, &bell->rings, FUTEX_WAKE, 1, nullptr, nullptr, 0) > 0;
}

bool Doorbells::sleep(std::uint32_t heard, Ranks callers, std::chrono::nanoseconds longest) const {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(longest);
  const timespec patience{time_t(seconds.count()), long((longest - seconds).count())};
  mine_->core = sched_getcpu();
  mine_->missing = callers;
  const bool rung = syscall(SYS_futex, &mine_->rings, FUTEX_WAIT, heard, &patience, nullptr, 0) == 0 || errno == EAGAIN;
  mine_->missing = nobody;
  return rung;
}

void Doorbells::wake(int rank) const {
  if (!reach(rank))
    return;
  bells_[rank]->missing = anybody;
  ring(rank);
}

void Doorbells::ring(const std::vector<int> &ranks) const {
  bool wakes_neighbour = false;
  for (const bool on_own_core : {false, true})
    for (const int rank : ranks)
      if (shares_core(rank) == on_own_core)
        wakes_neighbour |= ring(rank) && on_own_core;
  if (wakes_neighbour)
    sched_yield();
}

#else

bool Doorbells::reach_everybody() const { return false; }

bool Doorbells::ring(int) const { return false; }

void Doorbells::wake(int) const {}

void Doorbells::ring(const std::vector<int> &) const {}

bool Doorbells::sleep(std::uint32_t, Ranks, std::chrono::nanoseconds longest) const {
  std::this_thread::sleep_for(longest);
  return false;
}

#endif

} // namespace heartbus::bus
