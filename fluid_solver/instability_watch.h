#pragma once

#include <algorithm>
#include <deque>

namespace heartbus::fluid {

/// Recognises that the coupling runs away. What blood and wall disagree by at the end of a step, alpha |u - v|, is a
/// pressure that the next step has to make up for. The pressure in a beating heart changes by 3e5 Pa/s; a valve that
/// switches makes a jump of one step. An instability instead asks for more step after step: it is recognised when six
/// steps in a row disagree by more than 1e6 Pa/s and the last three twice as much as those before, or all by 1e7 Pa/s.
class InstabilityWatch {
 public:
  explicit InstabilityWatch(double dt) : large_(1e6 * dt), huge_(1e7 * dt) {}

  /// The disagreement [Pa] of one more step. True: the coupling is unstable.
  bool add(double disagreement) {
    last_.push_back(disagreement);
    if (last_.size() > 6)
      last_.pop_front();
    const auto lowest = *std::min_element(last_.begin(), last_.end());
    if (last_.size() < 6 || !(lowest > large_))
      return false;
    const double before = *std::max_element(last_.begin(), last_.begin() + 3);
    return lowest > huge_ || *std::max_element(last_.begin() + 3, last_.end()) > 2 * before;
  }

 private:
  double large_, huge_;
  std::deque<double> last_;
};

} // namespace heartbus::fluid
