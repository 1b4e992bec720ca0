#pragma once

#include "common/bus/node_array.h"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mpi.h>
#include <vector>

namespace heartbus::bus {

/// One bell for each rank of a node, in memory that they share: who has sent something rings, and a sleeping receiver
/// wakes within microseconds. MPI itself has no wait that leaves the core to others. Ranks of other nodes cannot be
/// rung; they look after their messages by themselves (see Waiting), as do all where there are no futexes (Linux has
/// them). Who sleeps says whom for and wakes when all of them have rung, because a look takes the core from who works:
/// the fluid sleeps for the moved mesh while the wall sends it what it needs later and the coupler what comes next.
class Doorbells {
 public:
  using Ranks = std::uint64_t; ///< a set of ranks of the world; two that differ by a multiple of 63 are taken for one
  static constexpr Ranks anybody = 0;
  static constexpr Ranks only(int rank) { return Ranks(1) << rank % 63; }

  explicit Doorbells(MPI_Comm everybody) : bells_(everybody), mine_(&bells_.mine()) {} ///< collective
  void free() { bells_.free(); }                                                       ///< collective

  bool reach(int rank) const { return bells_.of(rank) != nullptr; } ///< whether it is of the same node
  bool reach_everybody() const;                                     ///< no message of anybody comes unannounced
  /// Ring after the message has been started, so that who wakes finds it.
  bool ring(int rank) const; ///< returns whether it wakes somebody
  /// All of them, those on the own core last; who wakes there may go on at once.
  void ring(const std::vector<int> &ranks) const;
  void wake(int rank) const;                                  ///< even if it sleeps for others
  std::uint32_t rings() const { return mine_->rings.load(); } ///< of this rank's bell, so far
  /// Sleeps until all `callers` (or one of anybody) have rung, or one of them that runs on the same core: that will be
  /// free soon, and looking for the other messages there is faster than being woken from another core. At most for
  /// `longest`; not at all if the bell has rung more than `heard` times. Take `heard` before looking for messages: then
  /// none is missed in between. Returns whether it has been rung, false after `longest`.
  bool sleep(std::uint32_t heard, Ranks callers, std::chrono::nanoseconds longest) const;

  /// Counters beside the bell, for what is said often and needs no words.
  struct Counters {
    std::atomic<std::uint32_t> turns{0};    ///< that have been passed on to this rank
    std::atomic<std::uint32_t> progress{0}; ///< commands that it has executed
    std::atomic<std::uint32_t> leave{0};    ///< the order to leave: the exit code plus one
  };
  Counters &counters(int rank) const { return bells_.of(rank)->counters; } ///< needs reach(rank)

 private:
  bool shares_core(int rank) const;               ///< as far as it has slept
  static constexpr Ranks nobody = Ranks(1) << 63; ///< who never rings
  struct alignas(64) Bell {
    std::atomic<std::uint32_t> rings{0};
    std::atomic<Ranks> missing{nobody}; ///< while it sleeps: who has yet to ring; else nobody
    std::atomic<int> core{-1};          ///< that it sleeps on
    Counters counters;
  };
  NodeArray<Bell> bells_;
  Bell *mine_;
};

} // namespace heartbus::bus
