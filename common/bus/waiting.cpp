#include "common/bus/waiting.h"

#include <algorithm>
#include <chrono>
#include <sched.h>
#include <sstream>
#include <thread>

namespace heartbus::bus {

bool Waiting::within(double seconds, const std::function<bool()> &done) const {
  using namespace std::chrono;
  const auto start = steady_clock::now();
  microseconds pause(20);
  while (!done()) {
    poll_();
    const auto waited = steady_clock::now() - start;
    if (waited > duration<double>(seconds))
      return false;
    if (waited < microseconds(50)) {
      sched_yield();
      continue;
    }
    std::this_thread::sleep_for(pause);
    pause = std::min(2 * pause, microseconds(200));
  }
  return true;
}

void Waiting::until(const std::function<bool()> &done, const std::function<Awaited()> &awaited, double patience) const {
  const double seconds = patience * deadline;
  if (within(seconds, done))
    return;
  const Awaited missing = awaited();
  std::ostringstream message;
  message << "waited " << seconds << " s (the deadline) for " << missing.what;
  throw Late(message.str(), missing.from);
}

} // namespace heartbus::bus
