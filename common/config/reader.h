#pragma once

#include "common/config/node.h"
#include "common/config/section.h"

#include <functional>

namespace heartbus::config {

using Describe = std::function<void(Section &)>;

/// Fills the variables that `describe` names from the nodes; whatever nobody asked for is an error.
void read(const Node &root, const Describe &describe);

} // namespace heartbus::config
