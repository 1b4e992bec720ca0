#pragma once

#include "common/config/section.h"

namespace heartbus::mech {

/// The keys of the scene block `mechanics`.
struct Parameters {
  void describe(config::Section &section);
};

} // namespace heartbus::mech
