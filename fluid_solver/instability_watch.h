#pragma once

#include <algorithm>
#include <deque>

namespace heartbus::fluid {

/// Recognises that the coupling runs away. What blood and wall disagree by at the end of a step, alpha |u - v|, is a
/// pressure that the next step has to make up for. The pressure in a beating heart changes by 3e5 Pa/s; a valve that
/// switches makes a jump of one step. An instability instead asks for more step after step: it is recognised when six
/// steps in a row disagree by more than 1e6 Pa/s and the last three twice as much as those before, or all by 1e7 Pa/s;
/// and at once, before the wall is torn, when a step disagrees by 1e7 Pa/s and by ten times the last Robin datum.
///
/// With alpha far beyond the wall's impedance (Dirichlet-Neumann) blood moves as the wall did one step earlier: alpha
/// |u - v| is alpha dt times the wall's acceleration, large even when all is well and for as long as a load lasts. Then
/// growth counts when the step changes the datum by more than itself, as amplification by less than -1 does, and six
/// such steps in a row count without it.
class InstabilityWatch {
 public:
  explicit InstabilityWatch(double dt) : large_(1e6 * dt), huge_(1e7 * dt) {}

  /// One more step: its disagreement [Pa], the same relative to the datum, whether it is one of Dirichlet-Neumann.
  /// True: the coupling is unstable.
  bool add(double disagreement, double datum_residual = 0, bool dirichlet = false) {
    if (disagreement > huge_ && datum_residual > 10)
      return true;
    larger_than_datum_ = datum_residual > 1 ? larger_than_datum_ + 1 : 0;
    last_.push_back(disagreement);
    if (last_.size() > 6)
      last_.pop_front();
    const auto lowest = *std::min_element(last_.begin(), last_.end());
    if (last_.size() < 6 || !(lowest > large_))
      return false;
    const bool grows = largest(3, 6) > 2 * largest(0, 3);
    return dirichlet ? (grows && larger_than_datum_ > 0) || larger_than_datum_ >= 6 : grows || lowest > huge_;
  }

 private:
  double largest(int first, int end) const { return *std::max_element(last_.begin() + first, last_.begin() + end); }

  double large_, huge_;
  std::deque<double> last_;
  int larger_than_datum_ = 0; ///< steps in a row
};

} // namespace heartbus::fluid
