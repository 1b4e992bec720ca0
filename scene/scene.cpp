#include "scene/scene.h"

#include "common/base/failure.h"
#include "common/config/printer.h"
#include "common/config/reader.h"
#include "common/geometry/shapes.h"
#include "common/units/nearest.h"
#include "common/units/units.h"
#include "scene/settings.h"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace heartbus {

namespace {

/// Names of scenes and participants become those of folders and files, words of a command line and of messages.
void check_name(config::Section &s, const std::string &key, const std::string &name, const std::string &what) {
  const auto is_plain = [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-' || c == '.' || c > 0x7f; };
  const unsigned char first = name.empty() ? ' ' : name[0];
  if (!std::all_of(name.begin(), name.end(), is_plain) || !is_plain(first) || first == '.' || first == '-' ||
      name.size() > 100 || config::printable(name) != name)
    s.fail(key, "'" + name + "' cannot name " + what +
                    ": letters, digits, '_', '-' and '.', the first a letter or digit, 100 at most");
}

/// The boundary parts that a scene names are those of its mesh.
void check_labels(config::Section &s, const std::string &key, const std::vector<std::string> &labels,
                  const std::vector<std::string> &known) {
  for (const auto &label : labels)
    if (std::find(known.begin(), known.end(), label) == known.end())
      s.fail(key, "the mesh has no boundary label '" + label + "'" + config::did_you_mean(label, known) + " It has " +
                      config::joined(known));
}

template <class Parameters>
void check_regions(config::Section &s, const std::string &key, const std::map<std::string, Parameters> &regions,
                   const std::vector<std::string> &known) {
  for (const auto &[region, parameters] : regions)
    if (std::find(known.begin(), known.end(), region) == known.end())
      s.fail(key, "the solid has no region '" + region + "'" + config::did_you_mean(region, known) + " It has " +
                      config::joined(known));
}

config::Describe describe(SceneParameters &scene) {
  return [&scene](config::Section &section) { scene.describe(section); };
}

SceneParameters read(const config::Node &root) {
  SceneParameters scene;
  config::read(root, describe(scene));
  return scene;
}

/// Whatever goes wrong is one line with its place.
template <class Action>
auto told_in_one_line(const std::string &file_name, const Action &action) {
  try {
    return action();
  } catch (const Failure &failure) {
    throw Failure(failure.code(), config::printable(failure.what()));
  } catch (const std::exception &error) {
    throw Failure(ExitCode::scene, config::printable(file_name + ":1: this scene cannot be read: " + error.what()));
  }
}

} // namespace

SceneParameters::SceneParameters() {
  for (const char *participant : {"ep", "mech", "ale", "fluid"})
    participants[participant].program = participant + std::string("_solver");
}

void SceneParameters::describe(config::Section &s) {
  s.text("scene", name, "name of the scene and of its folder of results");
  check_name(s, "scene", name, "a folder");
  geometry.describe(s.section("geometry", "shape and meshes"));
  config::Section &directions = s.section("fibres", "fibre directions in the wall");
  fibres.describe(directions);
  fibres.ventricle = geometry.ventricle;
  if (fibres.rule == "ellipsoid" && geometry.shape != "ideal_left_ventricle")
    directions.fail("rule", "ellipsoid is for 'shape: ideal_left_ventricle'");
  config::Section &time_block = s.section("time", "beats and time steps");
  time.describe(time_block);
  coupling.describe(s.section("coupling", "how the participants take turns"));

  config::Section &who = s.section("participants", "who takes part");
  if (const auto names = who.free_keys(); !names.empty()) {
    const auto usual = participants;
    participants.clear();
    for (const auto &participant : names)
      if (const auto known = usual.find(participant); known != usual.end())
        participants.insert(*known);
      else
        participants[participant];
  }
  for (auto &[participant, parameters] : participants) {
    check_name(who, participant, participant, "a participant");
    parameters.describe(who.section(participant, ""));
    if (parameters.program.empty() && parameters.command.empty())
      who.fail(participant, "has neither 'program' nor 'command'");
  }

  config::Section &tissue = s.section("electrophysiology", "electrical activity");
  ep.describe(tissue);
  config::Section &wall = s.section("mechanics", "motion of the wall");
  mech.describe(wall);
  config::Section &lifting = s.section("lifting", "motion of the fluid's mesh");
  ale.describe(lifting);
  config::Section &blood = s.section("fluid", "blood");
  fluid.describe(blood);
  output.describe(s.section("output", "what is written"));
  time.settle(time_block, ep.stimulus.period);
  check_boundaries(s, directions, wall, lifting, blood);
  if (!ep.conductivity.regions.empty())
    check_regions(tissue, "conductivity", ep.conductivity.regions, geometry::solid_regions(geometry));
  check_consistency(s);
}

void SceneParameters::check_boundaries(config::Section &s, config::Section &directions, config::Section &wall,
                                       config::Section &lifting, config::Section &blood) const {
  const auto in_fluid = geometry::fluid_labels(geometry);
  const bool has_blood = has("fluid") || has("fsi");
  if (in_fluid.empty() && (has("ale") || has_blood))
    s.fail("geometry",
           geometry.shape == "file"
               ? "the mesh file has no fluid; `tools/mesh import SOLID FLUID` puts both in"
               : "the shape '" + geometry.shape + "' has no fluid; take ideal_left_ventricle, piston or tube");
  const auto known = geometry::solid_labels(geometry);
  const auto computes = [&](const std::string &name) { return has(name) && participants.at(name).program != "replay"; };
  if (known.empty() && (has("ep") || computes("mech") || has("fsi")))
    s.fail("geometry", "the mesh file has no solid; `tools/mesh import SOLID FLUID` puts both in");
  if (fibres.rule == "apicobasal")
    check_labels(directions, "rings", fibres.rings, known);
  if (fibres.rule != "constant" && fibres.rule != "file")
    check_labels(directions, "outflow", fibres.outflow.rings, known);
  if (computes("mech") || has("fsi")) {
    check_labels(wall, "fixed", mech.fixed, known);
    check_labels(wall, "rollers", mech.rollers, known);
    check_labels(wall, "pericardium", mech.pericardium.labels, known);
    for (const auto &[name, load] : mech.loads)
      check_labels(wall, "loads", {load.label}, known);
    check_regions(wall, "regions", mech.regions, geometry::solid_regions(geometry));
  }
  if (computes("ale")) {
    check_labels(lifting, "fixed", ale.fixed, in_fluid);
    check_labels(lifting, "slip", ale.slip, in_fluid);
  }
  if (has_blood) {
    check_labels(blood, "no_slip", fluid.no_slip, in_fluid);
    check_labels(blood, "slip", fluid.slip, in_fluid);
    if (!fluid.inlet.label.empty())
      check_labels(blood, "inlet", {fluid.inlet.label}, in_fluid);
  }
}

void SceneParameters::check_consistency(config::Section &s) const {
  if (fibres.rule == "file" && !geometry::brings_fibres(geometry))
    s.fail("fibres", "'rule: file' needs a mesh file with fibres: `tools/mesh import --fibres FILE` puts them in");
  if (time.until_periodic > 0 && !has("fluid") && !has("fsi") && !has("circulation"))
    s.fail("time",
           "'until_periodic' compares volumes and pressures of the blood; neither 'fluid' nor 'fsi' takes part");
  if (output.every > 0 && !is_multiple(output.every, time.step))
    s.fail("output", "'every' (" + config::shortest(output.every) + " s) must be a multiple of 'time.step' (" +
                         config::shortest(time.step) + " s)");
  if (const double every = output.checkpoint.every; every > 0 && every < time.step)
    s.fail("output", "'checkpoint.every' (" + config::shortest(every) + " s) is less than 'time.step' (" +
                         config::shortest(time.step) + " s); 0 s: only at the end");
  if (!mech.inertia && has("mech") && has("fluid") && coupling.has_robin_condition())
    s.fail("mechanics",
           "'inertia: false' is for a wall without blood, or with blood that only follows (scheme one_way)");
  if (has("ep") && ep.degree == 2 && geometry.cells != "tetrahedra")
    s.fail("electrophysiology", "'degree: 2' needs 'geometry: {cells: tetrahedra}'; hexahedra may be refined instead");
  if ((has("fsi") != (coupling.scheme == "E1FSinf") && !coupling.is_written()) ||
      (has("fsi") && (has("mech") || has("fluid"))))
    s.fail("participants", "the scheme E1FSinf has 'fsi' in place of 'mech' and 'fluid', and no other scheme has it");
  if (mech.model == "prescribed" && (has("fsi") || coupling.has_robin_condition()))
    s.fail("mechanics", "'model: prescribed' is a motion that the blood follows: 'coupling: {scheme: one_way}'");
  if (has("fsi") && !has("ale"))
    s.fail("participants", "'fsi' needs 'ale', which moves the fluid's mesh");
  if (has("mech") && has("fluid") && !has("ale"))
    s.fail("participants", "'mech' and 'fluid' need 'ale' between them, which moves the fluid's mesh");
  if ((has("fsi") || (has("mech") && has("fluid") && coupling.has_robin_condition())) &&
      mech.initial_pressure != fluid.initial_pressure)
    s.fail("fluid", "'initial_pressure' differs from that of 'mechanics': wall and blood must start in balance");
  if (coupling.iterations > 1 && !(has("mech") && has("fluid")))
    s.fail("coupling", "only a run of 'mech' and 'fluid' has anything to iterate; write 'iterations: 1'");
}

SceneParameters read_scene(const std::string &text, const std::string &file_name) {
  return told_in_one_line(file_name, [&] { return read(config::parse_yaml(text, file_name)); });
}

namespace {

using Values = std::vector<std::pair<std::string, std::string>>;

/// Of a key, or of all keys of a block.
Values values_within(const std::string &path, const Values &values) {
  Values found;
  for (const auto &entry : values)
    if (entry.first == path || entry.first.compare(0, path.size() + 1, path + ".") == 0)
      found.push_back(entry);
  return found;
}

SceneParameters loaded(const std::string &file_name, const std::vector<std::string> &settings) {
  config::Node root = config::load_yaml(file_name);
  lay_over(root, settings, read);
  return read(root);
}

} // namespace

SceneParameters load_scene(const std::string &file_name, const std::vector<std::string> &settings) {
  return told_in_one_line(file_name, [&] { return loaded(file_name, settings); });
}

std::vector<Change> changes(const std::string &file_name, const std::vector<std::string> &settings) {
  return told_in_one_line(file_name, [&] {
    config::Node root = config::load_yaml(file_name);
    SceneParameters before = read(root);
    const std::vector<Change> laid = lay_over(root, settings, read);
    SceneParameters after = read(root);
    const auto old_values = config::values(describe(before)), new_values = config::values(describe(after));
    std::map<std::string, Change> changed;
    for (const Change &change : laid) {
      const Values now = values_within(change.path, new_values); // of a list of blocks or of what is taken away none
      if (now.empty() || now != values_within(change.path, old_values))
        changed[change.path] = change;
    }
    std::vector<Change> sorted;
    for (const auto &[path, change] : changed)
      sorted.push_back(change);
    return sorted;
  });
}

std::string print_scene(SceneParameters scene) { return config::print(describe(scene)); }

} // namespace heartbus
