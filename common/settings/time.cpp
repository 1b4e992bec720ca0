#include "common/settings/time.h"

#include "common/config/printer.h"
#include "common/units/units.h"

#include <cmath>
#include <string>

namespace heartbus {

bool is_multiple(double whole, double part) {
  const double ratio = whole / part;
  return std::round(ratio) >= 1 && std::abs(ratio - std::round(ratio)) < 1e-6 * ratio;
}

int TimeParameters::n_steps() const { return static_cast<int>(std::lround(end / step)); }

void TimeParameters::describe(config::Section &s) {
  s.quantity_or("end", end, "s", {0, 1e6, true}, "beats", whole_beats, "end of the run");
  if (!whole_beats)
    beats = 0; // unless they are given too
  s.integer("beats", beats, {0, 100000},
            "length of the run in periods of the stimulus; of until_periodic the most; 0: 'end' is a time instead");
  s.quantity("until_periodic", until_periodic, "1", config::between(0, 1),
             "ends the run after a beat whose EDV, ESV and p_max differ by less from the beat before; 0: never");
  s.quantity("step", step, "s", config::between(1e-9, 1, "time steps are fractions of a millisecond"),
             "time step, the same for all participants");
}

/// Who gives both end and beats must mean the same by them.
void TimeParameters::settle(config::Section &s, double stimulus_period) {
  const auto seconds = [](double time) { return config::shortest(time) + " s"; };
  period = stimulus_period;
  if (whole_beats && beats == 0)
    s.fail("beats", "must be 1 at least where 'end' is not given");
  const double last = beats * period;
  if (!whole_beats && beats > 0 && std::abs(last - end) > 1e-9 * end)
    s.fail("end", "is " + seconds(end) + ", but 'beats: " + std::to_string(beats) + "' of " + seconds(period) +
                      " (electrophysiology.stimulus.period) end at " + seconds(last) + "; write one of the two");
  whole_beats = beats > 0;
  if (whole_beats)
    end = last;
  if (until_periodic > 0 && beats < 2)
    s.fail("until_periodic", "compares beats: it needs 'beats', the most that are allowed, two at least");
  if (end / step > 1e9)
    s.fail("step", "makes " + config::shortest(std::round(end / step)) + " steps; a run has 1e9 at most");
  if (!is_multiple(end, step))
    s.fail("step", "must divide the end of the run (" + seconds(end) + ") into whole steps");
}

} // namespace heartbus
