#pragma once

#include "common/config/section.h"

namespace heartbus::ale {

/// The keys of the scene block `lifting`.
struct Parameters {
  void describe(config::Section &section);
};

} // namespace heartbus::ale
