#pragma once

#include "scene/scene.h"

#include <map>
#include <string>

namespace heartbus {

/// What a state depends on and a run that goes on from it must agree with: shape and mesh, fibres, the models by name,
/// where the wall is held; of the physics that take part. Key and value as the resolved scene has them.
std::map<std::string, std::string> model_of(const SceneParameters &scene);

/// In what two of them differ, of what both have: "mechanics.law is guccione there and neo_hookean here"; or "".
std::string differences_of(const std::map<std::string, std::string> &there,
                           const std::map<std::string, std::string> &here);

} // namespace heartbus
