#include "common/bus/waiting.h"

#include <algorithm>
#include <chrono>
#include <sched.h>
#include <sstream>
#include <thread>

#ifdef __linux__
#include <sys/prctl.h>
#endif

namespace heartbus::bus {

namespace {

using namespace std::chrono;

constexpr microseconds shortest_pause(5), longest_pause(200);
constexpr milliseconds longest_nap(10); ///< an order to leave is noticed within this time
constexpr double long_wait = 2e-3;      ///< [s]
constexpr int naps_of_a_wait = 50;      ///< what takes long beyond that ends late by 1 %

/// How much of a recurring wait is slept through [s]: short ones vary more, and oversleeping them costs more.
double slept_through(const Habit &habit) {
  const double shorter = std::min(habit.last, habit.before);
  return (shorter < long_wait ? 0.5 : 0.75) * shorter;
}

} // namespace

Waiting::Waiting(std::function<void()> poll, const Doorbells *bells) : poll_(std::move(poll)), bells_(bells) {
#ifdef __linux__
  prctl(PR_SET_TIMERSLACK, 1000); // [ns]: a pause takes as long as it says, not 50 us longer
#endif
}

bool Waiting::sleep(std::uint32_t heard, nanoseconds longest) const {
  if (bells_)
    return bells_->sleep(heard, longest);
  std::this_thread::sleep_for(longest);
  return false;
}

bool Waiting::within(double seconds, const std::function<bool()> &done, Habit *habit) const {
  const auto start = steady_clock::now();
  auto expected = duration_cast<nanoseconds>(duration<double>(habit ? slept_through(*habit) : 0));
  nanoseconds pause = shortest_pause, waited(0);
  for (;; waited = steady_clock::now() - start) {
    const std::uint32_t heard = bells_ ? bells_->rings() : 0;
    if (done())
      break;
    poll_();
    if (waited > duration<double>(seconds))
      return false;
    if (waited < spin)
      sched_yield();
    else if (waited < expected) {
      if (sleep(heard, std::min<nanoseconds>(expected - waited, longest_nap))) {
        expected = waited; // something is on its way
        pause = shortest_pause;
      }
    } else {
      const nanoseconds overdue = waited - expected;
      if (sleep(heard, pause))
        pause = shortest_pause;
      else
        pause =
            std::min<nanoseconds>({2 * pause, std::max<nanoseconds>(longest_pause, overdue / naps_of_a_wait), longest_nap});
    }
  }
  if (habit)
    *habit = {duration<double>(waited).count(), habit->last};
  return true;
}

void Waiting::until(const std::function<bool()> &done, const std::function<Awaited()> &awaited, double patience,
                    Habit *habit) const {
  const double seconds = patience * deadline;
  if (within(seconds, done, habit))
    return;
  const Awaited missing = awaited();
  std::ostringstream message;
  message << "waited " << seconds << " s (the deadline) for " << missing.what;
  throw Late(message.str(), missing.from);
}

} // namespace heartbus::bus
