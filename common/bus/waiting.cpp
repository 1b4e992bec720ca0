#include "common/bus/waiting.h"

#include <algorithm>
#include <chrono>
#include <sched.h>
#include <sstream>
#include <thread>
#include <utility>

#ifdef __linux__
#include <sys/prctl.h>
#endif

namespace heartbus::bus {

namespace {

using namespace std::chrono;

constexpr microseconds spin(50), shortest_pause(5), longest_pause(200);
constexpr milliseconds longest_nap(10); ///< an order to leave is noticed within this time
constexpr double long_wait = 2e-3;      ///< [s]
constexpr int naps_of_a_wait = 50;      ///< what takes long beyond that ends late by 1 %

double usual(const Habit &habit) { return std::min(habit.last, habit.before); }

/// How much of a recurring wait is slept through [s]: short ones vary more, and oversleeping them costs more.
double slept_through(const Habit &habit) { return (usual(habit) < long_wait ? 0.5 : 0.75) * usual(habit); }

/// How long to sleep next.
struct Naps {
  nanoseconds expected; ///< when it becomes worth while to look
  nanoseconds pause = longest_nap, look = shortest_pause;

  nanoseconds between_rings() { return std::exchange(pause, std::min<nanoseconds>(4 * pause, longest_nap)); }
  nanoseconds without_bell(nanoseconds waited) {
    if (waited < expected)
      return std::min<nanoseconds>(expected - waited, longest_nap);
    const auto longest = std::max<nanoseconds>(longest_pause, (waited - expected) / naps_of_a_wait);
    return std::exchange(look, std::min<nanoseconds>({2 * look, longest, longest_nap}));
  }
  void woken(nanoseconds waited) {
    expected = waited; // something is on its way, which may take a moment
    pause = look = shortest_pause;
  }
};

} // namespace

Waiting::Waiting(std::function<void()> poll, std::function<bool()> is_sending, const Doorbells *bells)
    : poll_(std::move(poll)), is_sending_(std::move(is_sending)), bells_(bells) {
#ifdef __linux__
  prctl(PR_SET_TIMERSLACK, 1000); // [ns]: a pause takes as long as it says, not 50 us longer
#endif
}

bool Waiting::sleep(std::uint32_t heard, const Habit *habit, nanoseconds longest) const {
  if (bells_)
    return bells_->sleep(heard, habit ? habit->callers : Doorbells::anybody, longest);
  std::this_thread::sleep_for(longest);
  return false;
}

bool Waiting::within(double seconds, const std::function<bool()> &done, Habit *habit) const {
  const auto start = steady_clock::now();
  const bool announced = bells_ && bells_->reach_everybody();
  const bool is_short = habit && usual(*habit) < long_wait && (habit->comes_in_parts || !announced);
  const bool until_rung = announced && !is_short, is_whole = habit && !habit->comes_in_parts;
  Naps naps{duration_cast<nanoseconds>(duration<double>(habit ? slept_through(*habit) : 0))};
  nanoseconds waited(0), awake_until(habit && duration<double>(usual(*habit)) < spin ? spin : microseconds(0));
  for (;; waited = steady_clock::now() - start) {
    const std::uint32_t heard = bells_ ? bells_->rings() : 0;
    if (done())
      break;
    if (!until_rung || waited > nanoseconds(0)) // once asleep is soon enough: it leaves the core to others
      poll_();
    if (waited > duration<double>(seconds))
      return false;
    if ((is_short && waited < spin) || (is_whole && waited < awake_until))
      sched_yield();
    else if (sleep(heard, habit, until_rung && !is_sending_() ? naps.between_rings() : naps.without_bell(waited))) {
      if (!is_whole)
        naps.woken(waited);
      else
        awake_until = steady_clock::now() - start + spin;
    }
  }
  if (habit)
    habit->before = std::exchange(habit->last, duration<double>(waited).count());
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
