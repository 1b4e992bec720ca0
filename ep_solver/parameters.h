#pragma once

#include "common/config/section.h"

namespace heartbus::ep {

/// The keys of the scene block `electrophysiology`.
struct Parameters {
  void describe(config::Section &section);
};

} // namespace heartbus::ep
