#pragma once

#include "common/config/node.h"
#include "common/schema/scene.h"

#include <functional>

namespace heartbus {

/// Why a scene does not use a key ("'geometry.shape' is piston"); empty when it does, or when a program from elsewhere takes
/// part, which may use any.
std::string why_unused(const SceneParameters &scene, const std::string &path);

/// Lays "key=value" over a scene. A key may be shortened to its end; among several keys with this end it is the one that the
/// scene uses. `read` makes a scene of the tree. Failure(scene) when it is unknown, not unique or not used.
void lay_over(config::Node &root, const std::vector<std::string> &settings,
              const std::function<SceneParameters(const config::Node &)> &read);

} // namespace heartbus
