#pragma once

#include "common/config/section.h"

#include <string>
#include <vector>

namespace heartbus::ale {

/// The keys of the scene block `lifting`.
struct Parameters {
  std::vector<std::string> fixed{"base", "mitral", "aortic"}, slip;
  double tolerance = 1e-6; ///< of the linear solver, relative to what the interface's motion drives
  void describe(config::Section &section);
};

} // namespace heartbus::ale
