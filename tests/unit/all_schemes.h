#pragma once

#include "common/settings/coupling.h"

namespace heartbus::coupler {

/// Each scheme that has a name, with three iterations where it iterates.
inline std::vector<CouplingParameters> all_schemes() {
  std::vector<CouplingParameters> all;
  for (const char *name :
       {"EFS1", "EFS1-corrected", "E1FS", "adaptive", "by_phase", "E1FSinf", "one_way", "circulation"}) {
    CouplingParameters coupling;
    coupling.scheme = name;
    coupling.iterations = coupling.iterates() ? 3 : 1;
    all.push_back(coupling);
  }
  return all;
}

} // namespace heartbus::coupler
