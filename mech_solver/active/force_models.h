#pragma once

#include <string>
#include <vector>

/// The models of force generation there are: the name in the scene and the function that makes the model. One line a
/// model.
#define HEARTBUS_FORCE_MODELS(model) model("rdq18_ann", make_rdq18_ann) model("twitch", make_twitch) /* by name */

namespace heartbus::mech {

/// In the order of the list.
inline std::vector<std::string> force_model_names() {
  std::vector<std::string> names;
#define HEARTBUS_NAME(name, make) names.emplace_back(name);
  HEARTBUS_FORCE_MODELS(HEARTBUS_NAME)
#undef HEARTBUS_NAME
  return names;
}

} // namespace heartbus::mech
