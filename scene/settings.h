#pragma once

#include "common/config/node.h"
#include "scene/scene.h"

#include <functional>

namespace heartbus {

/// A setting as it was laid over a scene.
struct Change {
  std::string path;  ///< of the key, whole
  std::string key;   ///< its shortest end by which this scene knows it
  std::string value; ///< as written
};

/// Lays "key=value" over a scene. A key may be shortened to its end; among several keys with this end it is the one
/// that the scene uses. `read` makes a scene of the tree. Failure(scene) when it is unknown, not unique or not used.
std::vector<Change> lay_over(config::Node &root, const std::vector<std::string> &settings,
                             const std::function<SceneParameters(const config::Node &)> &read);

/// What settings change in a scene file, sorted by path: of several values for a key the last one; without those that
/// say what the scene says. Failure(scene) or Failure(file).
std::vector<Change> changes(const std::string &file_name, const std::vector<std::string> &settings);

} // namespace heartbus
