#include "coupler/options.h"

#include "common/base/failure.h"
#include "common/bus/world.h"
#include "common/geometry/mesh_writer.h"
#include "common/geometry/shapes.h"
#include "common/units/nearest.h"
#include "coupler/checkpoints.h"
#include "coupler/launch.h"
#include "coupler/results_name.h"
#include "coupler/sequence/sequence.h"
#include "scene/settings.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <sstream>

namespace heartbus::coupler {

std::optional<int> parse(int argc, char **argv, Options &options) {
  CLI::App app("Runs a scene: leads the participants of one mpirun through a coupling scheme.", "coupler");
  bool validate = false, print_defaults = false, launch_line = false;
  app.add_option("scene", options.scene_file, "scene file (YAML)");
  app.add_option("--set", options.settings, "key=value, laid over the scene")->take_all()->expected(1);
  app.add_option("--ranks", options.ranks, "MPI processes of every participant")->check(CLI::PositiveNumber);
  app.add_option("--out", options.folder, "folder of the results (default: results/<scene and what --set changes>)");
  app.add_option("--record", options.records, "field=FILE: records what is transferred")->take_all()->expected(1);
  app.add_option("--restart", options.restart,
                 "goes on from a checkpoint: 'latest', its time ('48 ms') or a folder (of a checkpoint or of results)");
  app.add_flag("--validate", validate, "checks the scene and ends");
  app.add_flag("--print-defaults", print_defaults, "prints every key with its default, unit and meaning");
  app.add_flag("--launch-line", launch_line, "checks the scene and prints the arguments for mpirun");
  app.add_option("--write-mesh", options.mesh_file, "writes the meshes of the scene's shape to a mesh file and ends");
  app.set_version_flag("--version", bus::version_of("coupler"));
  std::string default_scene; // the last two are for launchers
  app.add_option("--default-scene", default_scene, "")->group("");
  app.add_option("--hand-over", options.hand_over, "")->group("");
  try {
    app.parse(argc, argv);
    if (options.scene_file.empty())
      options.scene_file = default_scene;
    if (options.scene_file.empty() && !print_defaults)
      throw CLI::RequiredError("scene");
  } catch (const CLI::ParseError &error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::scene);
  }
  using Action = Options::Action;
  options.action = validate                                ? Action::validate
                   : print_defaults                        ? Action::print_defaults
                   : !options.mesh_file.empty()            ? Action::write_mesh
                   : launch_line || options.hand_over >= 0 ? Action::launch_line
                                                           : Action::run;
  return {};
}

SceneParameters scene_of(const Options &options) {
  SceneParameters scene = load_scene(options.scene_file, options.settings);
  if (options.ranks > 0)
    for (auto &[name, participant] : scene.participants)
      participant.ranks = options.ranks;
  std::vector<std::string> names;
  for (const auto &[name, participant] : scene.participants)
    names.push_back(name);
  check_names(scheme(scene.coupling), names);
  return scene;
}

std::string folder_of(const Options &options, const SceneParameters &scene) {
  return options.folder.empty() ? "results/" + results_name(scene.name, changes(options.scene_file, options.settings))
                                : options.folder;
}

std::vector<std::pair<std::string, std::string>> records_of(const Options &options) {
  std::vector<std::pair<std::string, std::string>> records;
  for (const auto &record : options.records) {
    const std::size_t sign = record.find('=');
    if (sign == std::string::npos || sign == 0 || sign + 1 == record.size())
      throw Failure(ExitCode::scene, "--record " + record + ": write field=FILE");
    records.push_back({record.substr(0, sign), record.substr(sign + 1)});
  }
  return records;
}

namespace {

/// A message about a key begins with the place of the key, or of the block that lacks it.
std::string with_place(const std::string &message, const std::string &scene_file) {
  const std::string begin = "key '";
  if (message.compare(0, begin.size(), begin) != 0)
    return message;
  const config::Node root = config::load_yaml(scene_file);
  const config::Node *node = &root;
  std::stringstream path(message.substr(begin.size(), message.find('\'', begin.size()) - begin.size()));
  for (std::string key; std::getline(path, key, '.');)
    if (const config::Node *next = node->find(key))
      node = next;
    else
      break;
  return node->where + ": " + message;
}

void write_meshes(const geometry::Parameters &shape, const std::string &file) {
  std::map<std::string, geometry::Mesh> parts;
  if (!geometry::solid_labels(shape).empty())
    parts["solid"] = geometry::make_solid(shape);
  if (!geometry::fluid_labels(shape).empty())
    parts["fluid"] = geometry::make_fluid(shape);
  geometry::write_mesh_file(file, parts);
}

} // namespace

int answer(const Options &given) {
  Options options = given;
  try {
    if (options.action == Options::Action::print_defaults) {
      std::cout << print_scene(SceneParameters());
      return 0;
    }
    const SceneParameters scene = scene_of(options);
    if (options.action == Options::Action::write_mesh) {
      write_meshes(scene.geometry, options.mesh_file);
      return 0;
    }
    options.folder = folder_of(options, scene);
    const std::vector<AppContext> contexts = launch(options, scene);
    if (!options.restart.empty())
      find_checkpoint(options.restart, options.folder, scene);
    if (options.action == Options::Action::validate)
      std::cout << options.scene_file << ": valid\n";
    else if (options.hand_over >= 0)
      hand_over(options.hand_over, contexts, options, scene);
    else
      std::cout << launch_line(contexts) << '\n';
    return 0;
  } catch (const Failure &failure) {
    std::cerr << "error: " << config::printable(with_place(failure.what(), options.scene_file)) << '\n';
    return static_cast<int>(failure.code());
  } catch (const std::exception &error) {
    std::cerr << "error: " << config::printable(options.scene_file + ":1: " + error.what()) << '\n';
    return static_cast<int>(ExitCode::scene);
  }
}

} // namespace heartbus::coupler
