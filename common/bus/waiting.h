#pragma once

#include "common/base/failure.h"
#include "common/bus/doorbell.h"

#include <functional>
#include <string>

namespace heartbus::bus {

/// What a wait is for, and which participant should provide it.
struct Awaited {
  std::string what, from;
};

/// Somebody waited too long; `waits_for` names who kept him waiting.
class Late : public Failure {
 public:
  Late(const std::string &message, const std::string &waits_for)
      : Failure(ExitCode::deadline, message), waits_for(waits_for) {}
  const std::string waits_for;
};

/// A wait that recurs in each step: who ends it, and how long it took the last two times [s].
struct WaitHistory {
  Doorbells::Ranks callers = Doorbells::anybody;
  double last = 0, before = 0;
};

/// Waits asleep until its bell is rung by those it waits for, besides which it wakes once in 100 ms: each look costs
/// those who work on its core 10 to 20 us. It looks for 150 us before it sleeps where a wait is usually that short, and
/// after the bell has rung, for there may be several to wait for. It looks more often while something of its own is
/// under way and where there are ranks whose bells cannot be reached. There it spins for 150 us in waits of usually
/// less than 2 ms (most answers come at once), sleeps through half of what a recurring wait took, or three quarters of
/// a long one, then 5 us at a time, doubling up to 200 us or, if that is more, a fiftieth of the time since (at most 10
/// ms). So an idle rank leaves its core to the working ones and is still awake in time. Before it sleeps again it calls
/// `poll`, which looks for an order to leave and throws it; `done` has to look by itself for what it waits for.
class Waiting {
 public:
  /// `is_sending`: whether messages of its own are under way, which may need its help and end without a ring.
  Waiting(std::function<void()> poll, std::function<bool()> is_sending, const Doorbells *bells);

  double deadline = 60; ///< [s]; the scene's value from the handshake on

  /// Returns when `done()`; Late("waited .. s for ..") after `patience` deadlines. `habit` is kept by the caller for
  /// waits that recur.
  void until(const std::function<bool()> &done, const std::function<Awaited()> &awaited, double patience = 1,
             WaitHistory *history = nullptr) const;
  /// As above, but gives up silently: false after `seconds`.
  bool within(double seconds, const std::function<bool()> &done, WaitHistory *history = nullptr) const;
  /// Waits that were over though nobody had rung: noticed up to 100 ms late. None, unless a message is overtaken by its
  /// ring.
  int n_overslept() const { return n_overslept_; }

 private:
  bool sleep(std::uint32_t heard, const WaitHistory *history,
             std::chrono::nanoseconds longest) const; ///< returns whether the bell rang

  std::function<void()> poll_;
  std::function<bool()> is_sending_;
  const Doorbells *bells_;
  mutable int n_overslept_ = 0;
};

} // namespace heartbus::bus
