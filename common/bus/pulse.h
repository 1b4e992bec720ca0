#pragma once

#include <chrono>
#include <string>

namespace heartbus::bus {

/// What the coupler tells who watches the launch from outside, in the file that HEARTBUS_PULSE names: a line with a
/// count, what it is at ("meeting", "working", "ending") and the step. The count goes on while the coupler lives.
/// Without such a file it says nothing.
class Pulse {
 public:
  Pulse();
  Pulse(const Pulse &) = delete;
  ~Pulse();
  void beat(const std::string &stage, int step);

 private:
  int file_ = -1;
  long count_ = 0;
  std::string told_;
  std::chrono::steady_clock::time_point when_;
};

} // namespace heartbus::bus
