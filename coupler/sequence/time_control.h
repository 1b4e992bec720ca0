#pragma once

#include "common/bus/solver.h"
#include "scene/scene.h"

#include <algorithm>
#include <cmath>

namespace heartbus::coupler {

/// The time axis: steps of one size, t^n = n dt without accumulated rounding, and beats of one period.
class TimeControl {
 public:
  /// At every so many steps the participants drop all that is not in their state, and only there a run is saved or
  /// stopped on request: so a restarted run has the very bits of one that was not interrupted. Small enough to stop
  /// soon, large enough that making preconditioners and tangents anew costs next to nothing.
  static constexpr int refresh_interval = 20;
  static bool refreshes_at(int number) { return number % refresh_interval == 0; }
  /// The first such step from this one on, or the last step of all: so far the run is foreseeable.
  int next_refresh(int number) const {
    return std::min((number + refresh_interval - 1) / refresh_interval * refresh_interval, n_steps_);
  }
  int last_refresh() const { return n_steps_ - n_steps_ % refresh_interval; }

  explicit TimeControl(const TimeParameters &time) : size_(time.step), period_(time.period), n_steps_(time.n_steps()) {}
  int n_steps() const { return n_steps_; }
  /// The step that ends at t^number; 0 is the start block.
  bus::Step step(int number) const { return {number, 0, number * size_, size_}; }

  /// How many beats are complete after this step.
  int beats_done(int number) const { return static_cast<int>(std::floor(number * size_ / period_ + 1e-9)); }
  /// The beat that this step belongs to, from 1 on.
  int beat(int number) const { return 1 + (number > 0 ? beats_done(number - 1) : 0); }
  int n_beats() const { return beat(n_steps_); } ///< the last of which may be incomplete
  /// Whether this is where a run can end after a beat: where the beat ends, or the first step after it that refreshes.
  bool may_end_after_beat(int number) const {
    return refreshes_at(number) && beats_done(number) > beats_done(number - refresh_interval);
  }

 private:
  double size_, period_;
  int n_steps_;
};

} // namespace heartbus::coupler
