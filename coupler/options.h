#pragma once

#include "scene/scene.h"

#include <optional>
#include <string>
#include <vector>

namespace heartbus::coupler {

/// The command line of the coupler.
struct Options {
  std::string scene_file;
  std::vector<std::string> settings; ///< "key=value", laid over the scene
  int ranks = 0;                     ///< for every participant; 0: as the scene says
  std::string folder;                ///< of the results; empty: in results/, see results_name.h
  std::vector<std::string> records;  ///< "field=FILE"
  std::string restart;               ///< from which checkpoint: see find_checkpoint; empty: from the start
  std::string mesh_file;             ///< to be written from the scene's shape; empty: none
  int hand_over = -1;                ///< open file for a launcher, see coupler/launch.h; -1: none
  enum class Action { run, validate, print_defaults, launch_line, write_mesh } action = Action::run;
};

/// Parses the command line; an exit code when there is nothing more to do (help, wrong usage).
std::optional<int> parse(int argc, char **argv, Options &options);

/// The scene with all settings of the command line.
SceneParameters scene_of(const Options &options);

/// Where the results of this scene go: as told, or in results/ of the current folder.
std::string folder_of(const Options &options, const SceneParameters &scene);

/// (field, file) of every --record.
std::vector<std::pair<std::string, std::string>> records_of(const Options &options);

/// Does what needs no launch: --validate, --print-defaults, --launch-line, --write-mesh. Returns the exit code.
int answer(const Options &options);

} // namespace heartbus::coupler
