#pragma once

#include "common/config/section.h"

namespace heartbus::fluid {

/// The keys of the scene block `fluid`.
struct Parameters {
  void describe(config::Section &section);
};

} // namespace heartbus::fluid
