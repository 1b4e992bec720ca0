#pragma once

#include "common/config/section.h"

namespace heartbus {

struct CheckpointParameters {
  double every = 50e-3; ///< interval between checkpoints [s]; 0: only at the end or when the run is stopped
  int keep = 2;         ///< how many remain
  void describe(config::Section &section);
};

struct OutputParameters {
  double every = 10e-3; ///< interval between written fields [s]; 0: none
  CheckpointParameters checkpoint;
  bool trace = false; ///< trace.json: what every rank does when
  /// Whether fields are written after this step (0 is the start block).
  bool due(int step_number, double step_size) const;
  void describe(config::Section &section);
};

} // namespace heartbus
