#pragma once

#include "common/bus/doorbell.h"
#include "common/bus/failure.h"

#include <chrono>
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

/// How long a wait that recurs in each step took the last two times [s].
struct Habit {
  double last = 0, before = 0;
};

/// Waits asleep until the bell rings. For what does not ring (senders on other nodes, later stages of collective operations) it
/// also looks by itself: it spins at first (most answers come at once), sleeps through half of what a recurring wait took, or
/// three quarters of a long one, then 5 us at a time, doubling up to 200 us or, if that is more, a fiftieth of the time since (at
/// most 10 ms). So an idle rank leaves its core to the working ones and is still awake in time. Every round also calls
/// `poll`, which looks for an order to leave and throws it.
class Waiting {
 public:
  explicit Waiting(std::function<void()> poll, const Doorbells *bells = nullptr);

  double deadline = 60;              ///< [s]; the scene's value from the handshake on
  std::chrono::microseconds spin{50}; ///< before it sleeps

  /// Returns when `done()`; Late("waited .. s for ..") after `patience` deadlines. `habit` is kept by the caller for
  /// waits that recur.
  void until(const std::function<bool()> &done, const std::function<Awaited()> &awaited, double patience = 1,
             Habit *habit = nullptr) const;
  /// As above, but gives up silently: false after `seconds`.
  bool within(double seconds, const std::function<bool()> &done, Habit *habit = nullptr) const;

 private:
  bool sleep(std::uint32_t heard, std::chrono::nanoseconds longest) const; ///< returns whether the bell rang

  std::function<void()> poll_;
  const Doorbells *bells_;
};

} // namespace heartbus::bus
