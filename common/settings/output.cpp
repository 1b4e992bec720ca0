#include "common/settings/output.h"

#include <cmath>

namespace heartbus {

void CheckpointParameters::describe(config::Section &s) {
  s.quantity("every", every, "s", config::non_negative,
             "interval, rounded up to an allowed step; 0 s: only at the end or when the run is stopped");
  s.integer("keep", keep, {1, 1000}, "how many checkpoints remain");
}

bool OutputParameters::due(int step_number, double step_size) const {
  return every > 0 && step_number % std::lround(every / step_size) == 0;
}

void OutputParameters::describe(config::Section &s) {
  s.quantity("every", every, "s", config::non_negative, "interval between written fields; 0 s writes none");
  checkpoint.describe(s.section("checkpoint", "states from which --restart goes on"));
  s.boolean("trace", trace,
            "writes trace.json: what every rank does when, in the format of chrome://tracing and Perfetto");
}

} // namespace heartbus
