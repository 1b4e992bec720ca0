#pragma once

#include "common/config/reader.h"

namespace heartbus::config {

/// The variables that `describe` names as a scene, with units and, as comments, their meaning. Reading this text gives
/// the same values again, to the last bit.
std::string print(const Describe &describe);

/// The dotted path and the printed value of every key that `describe` names but blocks and lists of blocks.
std::vector<std::pair<std::string, std::string>> values(const Describe &describe);

/// The dotted path of every key that `describe` names.
std::vector<std::string> key_paths(const Describe &describe);

} // namespace heartbus::config
