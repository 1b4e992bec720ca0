#include "common/bus/doorbell.h"

#include <cerrno>
#include <thread>

#ifdef __linux__
#include <linux/futex.h>
#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

namespace heartbus::bus {

#ifdef __linux__

bool Doorbells::reach_everybody() const {
  for (int rank = 0; rank < bells_.n_ranks(); ++rank)
    if (!reach(rank))
      return false;
  return true;
}

bool Doorbells::shares_core(int rank) const { return reach(rank) && bells_.of(rank)->core == sched_getcpu(); }

bool Doorbells::ring(int rank) const {
  Bell *bell = bells_.of(rank);
  if (!bell)
    return false;
  bell->rings.fetch_add(1);
  const Ranks others = ~only(bells_.rank()), before = bell->missing.fetch_and(others);
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
  bells_.of(rank)->missing = anybody;
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
