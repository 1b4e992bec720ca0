#pragma once

#include "common/config/node.h"
#include "scene/scene.h"

#include <functional>

namespace heartbus {

/// Lays "key=value" over a scene. A key may be shortened to its end; among several keys with this end it is the one
/// that the scene uses. `read` makes a scene of the tree. Failure(scene) when it is unknown, not unique or not used.
void lay_over(config::Node &root, const std::vector<std::string> &settings,
              const std::function<SceneParameters(const config::Node &)> &read);

} // namespace heartbus
