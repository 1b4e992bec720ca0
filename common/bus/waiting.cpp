#include "common/bus/waiting.h"

#include <algorithm>
#include <chrono>
#include <sched.h>
#include <sstream>
#include <thread>
#include <utility>

namespace heartbus::bus {

namespace {

using namespace std::chrono;

constexpr microseconds spin(150), shortest_pause(5), longest_pause(200);
constexpr milliseconds longest_nap(10), longest_sleep(100); ///< an order to leave is noticed within this time
constexpr double long_wait = 2e-3;                          ///< [s]
constexpr int naps_of_a_wait = 50;                          ///< what takes long beyond that ends late by 1 %

double usual(const WaitHistory &history) { return std::min(history.last, history.before); }

/// How much of a recurring wait is slept through [s]: short ones vary more, and oversleeping them costs more.
double slept_through(const WaitHistory &history) { return (usual(history) < long_wait ? 0.5 : 0.75) * usual(history); }

/// How long to sleep next, where no bell tells when it becomes worth while to look.
struct Naps {
  nanoseconds expected, pause = shortest_pause;

  nanoseconds next(nanoseconds waited) {
    if (waited < expected)
      return std::min<nanoseconds>(expected - waited, longest_nap);
    const auto longest = std::max<nanoseconds>(longest_pause, (waited - expected) / naps_of_a_wait);
    return std::exchange(pause, std::min<nanoseconds>({2 * pause, longest, longest_nap}));
  }
};

} // namespace

Waiting::Waiting(std::function<void()> poll, std::function<bool()> is_sending, const Doorbells *bells)
    : poll_(std::move(poll)), is_sending_(std::move(is_sending)), bells_(bells) {}

bool Waiting::sleep(std::uint32_t heard, const WaitHistory *history, nanoseconds longest) const {
  if (bells_)
    return bells_->sleep(heard, history ? history->callers : Doorbells::anybody, longest);
  std::this_thread::sleep_for(longest);
  return false;
}

bool Waiting::within(double seconds, const std::function<bool()> &done, WaitHistory *history) const {
  const auto start = steady_clock::now();
  const bool announced = bells_ && bells_->reach_everybody();
  Naps naps{duration_cast<nanoseconds>(duration<double>(history ? slept_through(*history) : 0))};
  const double looks_if_below = announced ? duration<double>(spin).count() : long_wait;
  nanoseconds waited(0), awake_until(history && usual(*history) < looks_if_below ? spin : microseconds(0));
  std::uint32_t heard_before_sleep = 0;
  bool sleeps_long = false;
  for (bool has_slept = !announced;; waited = steady_clock::now() - start) {
    const std::uint32_t heard = bells_ ? bells_->rings() : 0;
    if (done()) {
      n_overslept_ += sleeps_long && heard == heard_before_sleep;
      break;
    }
    if (waited < awake_until) {
      sched_yield();
      continue;
    }
    if (has_slept) // once asleep is soon enough: it leaves the core to others
      poll_();
    if (waited > duration<double>(seconds))
      return false;
    sleeps_long = announced && !is_sending_();
    heard_before_sleep = heard;
    if (sleep(heard, history, sleeps_long ? longest_sleep : naps.next(waited)))
      awake_until = steady_clock::now() - start + spin;
    has_slept = true;
  }
  if (history)
    history->before = std::exchange(history->last, duration<double>(waited).count());
  return true;
}

void Waiting::until(const std::function<bool()> &done, const std::function<Awaited()> &awaited, double patience,
                    WaitHistory *history) const {
  const double seconds = patience * deadline;
  if (within(seconds, done, history))
    return;
  const Awaited missing = awaited();
  std::ostringstream message;
  message << "waited " << seconds << " s (the deadline) for " << missing.what;
  throw Late(message.str(), missing.from);
}

} // namespace heartbus::bus
