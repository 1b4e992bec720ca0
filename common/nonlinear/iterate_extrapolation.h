#pragma once

#include "common/nonlinear/extrapolation.h"

#include <cstddef>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

namespace heartbus::fem {

/// First guesses for a solver that is called several times in a time step, with data that settle from call to call:
/// what iterate k moves from iterate k - 1, and the first one from the extrapolated states, which are last iterates, is
/// extrapolated from the steps before by the parabola through the last three, or what there is of it.
template <class Vector>
class IterateExtrapolation {
 public:
  /// Moves x, the extrapolated state (iteration 0) or the last iterate, to where the next iterate is expected.
  void predict(int iteration, Vector &x) const {
    std::size_t known = 0;
    while (known < history_.size() && std::size_t(iteration) < history_[known].size())
      ++known;
    for (std::size_t age = 0; age < known; ++age)
      x.add(extrapolation_weight(known, age), history_[age][iteration]);
  }
  /// The iterate that was found; a correction of it counts as the next one.
  void record(int iteration, const Vector &x) {
    if (iteration == 0) {
      current_.assign(1, x);
      current_[0] = 0;
    } else {
      current_.push_back(x);
      current_.back() -= *last_;
      current_[0] -= current_.back();
    }
    last_ = x;
  }
  /// The step is done. One without a second iterate leaves nothing to expect.
  void commit() {
    if (current_.size() <= 1)
      return forget();
    history_.push_front(std::move(current_));
    if (history_.size() > 3)
      history_.pop_back();
  }
  void forget() { history_.clear(); }

 private:
  std::deque<std::vector<Vector>> history_; ///< [steps ago][iteration]; the first from the last iterate to the first
  std::vector<Vector> current_;
  std::optional<Vector> last_;
};

} // namespace heartbus::fem
