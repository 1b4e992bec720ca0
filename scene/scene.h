#pragma once

#include "ale_solver/settings/parameters.h"
#include "common/config/node.h"
#include "common/config/section.h"
#include "common/geometry/parameters.h"
#include "common/settings/coupling.h"
#include "common/settings/output.h"
#include "common/settings/participants.h"
#include "common/settings/time.h"
#include "ep_solver/settings/parameters.h"
#include "fluid_solver/settings/parameters.h"
#include "mech_solver/settings/parameters.h"

#include <map>
#include <string>
#include <vector>

namespace heartbus {

/// Everything a scene says, whoever it is for.
struct SceneParameters {
  std::string name = "scene";
  geometry::Parameters geometry;
  geometry::FibreParameters fibres;
  TimeParameters time;
  CouplingParameters coupling;
  std::map<std::string, ParticipantParameters> participants; ///< by name: ep, mech, ale, fluid, fsi, ...
  ep::Parameters ep;
  mech::Parameters mech;
  ale::Parameters ale;
  fluid::Parameters fluid;
  OutputParameters output;

  SceneParameters();
  bool has(const std::string &participant) const { return participants.count(participant) > 0; }
  void describe(config::Section &section);

 private:
  void check_consistency(config::Section &section) const;
  void check_boundaries(config::Section &section, config::Section &directions, config::Section &wall,
                        config::Section &lifting, config::Section &blood) const;
};

/// Reads a scene from its text, as every participant gets it from the coupler. Throws Failure(scene).
SceneParameters read_scene(const std::string &text, const std::string &file_name);

/// Reads a scene file and lays settings "path=value" over it, where the path may be shortened as long as its end is
/// unique among the keys that the scene uses ("alpha=8000 kg/(m^2 s)", "mech.ranks=2"; see settings.h). Throws
/// Failure(scene) or Failure(file).
SceneParameters load_scene(const std::string &file_name, const std::vector<std::string> &settings);

/// The scene with all its values, units and their meaning, as text that reads back to the same scene.
std::string print_scene(SceneParameters scene);

} // namespace heartbus
