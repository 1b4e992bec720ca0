#include "scene/model.h"

#include "common/config/printer.h"
#include "common/geometry/shapes.h"

namespace heartbus {

namespace {

bool starts_with(const std::string &text, const std::string &start) {
  return text.compare(0, start.size(), start) == 0;
}

} // namespace

std::map<std::string, std::string> model_of(const SceneParameters &scene) {
  const std::string &shape = scene.geometry.shape;
  const bool is_ventricle = shape == "ideal_left_ventricle";
  std::vector<std::string> keys{"geometry.shape", "geometry.cells",
                                "geometry." + (is_ventricle ? "ventricle" : shape) + "."}; // `file` has no block
  if (is_ventricle)
    keys.push_back("geometry.mesh");
  if (scene.has("ep"))
    for (const char *key : {"fibres.", "electrophysiology.model", "electrophysiology.ionic_model",
                            "electrophysiology.refinements", "electrophysiology.degree"})
      keys.push_back(key);
  if (scene.has("mech") || scene.has("fsi"))
    for (const char *key : {"fibres.", "mechanics.law", "mechanics.regions.", "mechanics.active.model",
                            "mechanics.fixed", "mechanics.rollers"})
      keys.push_back(key);

  SceneParameters copy = scene;
  std::map<std::string, std::string> model;
  for (const auto &[path, value] : config::values([&](config::Section &section) { copy.describe(section); }))
    for (const auto &key : keys)
      if (path == key || (key.back() == '.' && starts_with(path, key)))
        model[path] = value;
  if (shape == "file")
    model["geometry.mesh"] = geometry::checksum_of_meshes(scene.geometry);
  return model;
}

std::string differences_of(const std::map<std::string, std::string> &there,
                           const std::map<std::string, std::string> &here) {
  std::string text;
  for (const auto &[key, value] : there)
    if (const auto same = here.find(key); same != here.end() && same->second != value)
      text += (text.empty() ? "" : "; ") + key + " is " + value + " there and " + same->second + " here";
  return text;
}

} // namespace heartbus
