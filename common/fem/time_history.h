#pragma once

#include "common/fem/lagrange_space.h"
#include "common/nonlinear/extrapolation.h"

#include <vector>

namespace heartbus::fem {

/// The last states of a field, at equal steps: [0] is that of t^n, [k] that of t^{n-k}. What it copies are the owned
/// values; ghosts of a state are the caller's to bring up to date.
class TimeHistory {
 public:
  TimeHistory(unsigned depth, const Vector &like) : states_(depth, like) {}
  Vector &operator[](unsigned age) { return states_[age]; }
  const Vector &operator[](unsigned age) const { return states_[age]; }

  /// x becomes the newest, the oldest is dropped.
  void push(const Vector &x) {
    for (unsigned age = states_.size() - 1; age > 0; --age)
      states_[age].swap(states_[age - 1]);
    copy_owned(x, states_[0]);
  }
  /// It was always like this.
  void fill(const Vector &x) {
    for (Vector &state : states_)
      copy_owned(x, state);
  }
  /// The last state was always there: nothing to extrapolate from.
  void forget() {
    for (unsigned age = 1; age < states_.size(); ++age)
      copy_owned(states_[0], states_[age]);
  }
  /// Older states lie on the line through the last two.
  void straighten() {
    for (unsigned age = 2; age < states_.size(); ++age) {
      copy_owned(states_[age - 1], states_[age]);
      states_[age].sadd(2, -1, states_[age - 2]);
    }
  }
  /// x^{n+1} of the polynomial through all of them.
  void extrapolate(Vector &x) const {
    const unsigned n = states_.size();
    copy_owned(states_[0], x);
    x.sadd(extrapolation_weight(n, 0), extrapolation_weight(n, 1), states_[1]);
    for (unsigned age = 2; age < n; ++age)
      x.add(extrapolation_weight(n, age), states_[age]);
  }

 private:
  std::vector<Vector> states_;
};

} // namespace heartbus::fem
