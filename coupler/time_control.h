#pragma once

#include "common/bus/solver.h"
#include "common/schema/scene.h"

namespace heartbus::coupler {

/// The time axis: steps of one size, t^n = n dt without accumulated rounding.
class TimeControl {
 public:
  explicit TimeControl(const TimeParameters &time) : size_(time.step), n_steps_(time.n_steps()) {}
  int n_steps() const { return n_steps_; }
  /// The step that ends at t^number; 0 is the start block.
  bus::Step step(int number) const { return {number, 0, number * size_, size_}; }

 private:
  double size_;
  int n_steps_;
};

} // namespace heartbus::coupler
