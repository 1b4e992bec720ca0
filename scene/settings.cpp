#include "scene/settings.h"

#include "common/base/failure.h"
#include "common/config/printer.h"
#include "common/geometry/shapes.h"
#include "common/units/nearest.h"
#include "mech_solver/active/force_models.h"

#include <algorithm>

namespace heartbus {

namespace {

using Words = std::vector<std::string>;

bool is_in(const std::string &word, const Words &words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

bool is_within(const std::string &path, const std::string &block) {
  return path.compare(0, block.size(), block) == 0 && (path.size() == block.size() || path[block.size()] == '.');
}

bool has_end(const std::string &path, const std::string &end) {
  return path == end ||
         (path.size() > end.size() && path.compare(path.size() - end.size() - 1, std::string::npos, "." + end) == 0);
}

/// Whether a program takes part that is among these, or one that is not ours.
bool takes_part(const SceneParameters &scene, const Words &programs) {
  const Words ours{"ep_solver", "mech_solver", "ale_solver", "fluid_solver", "fsi_solver", "cavity_solver", "replay"};
  return std::any_of(scene.participants.begin(), scene.participants.end(), [&](const auto &participant) {
    const std::string &program = participant.second.program, name = program.substr(program.rfind('/') + 1);
    return is_in(name, programs) || !is_in(name, ours);
  });
}

/// Blocks of keys, what they need, whether this scene has it.
struct Use {
  Words blocks;
  bool is_used;
  std::string otherwise;
};

std::vector<Use> uses_of_geometry(const SceneParameters &scene) {
  const auto &geometry = scene.geometry;
  std::vector<Use> uses;
  for (const auto &[block, shape] :
       {std::pair{"ventricle", "ideal_left_ventricle"}, {"piston", "piston"}, {"slab", "slab"}, {"tube", "tube"}})
    uses.push_back(
        {{std::string("geometry.") + block}, geometry.shape == shape, "'geometry.shape' is " + geometry.shape});
  uses.push_back({{"geometry.mesh"},
                  !is_in(geometry.shape, {"piston", "slab", "tube"}),
                  "'geometry.shape' is " + geometry.shape + ", whose keys give its cells"});
  const auto &rule = scene.fibres.rule;
  const std::string otherwise = "'fibres.rule' is " + rule;
  uses.push_back({{"fibres.angle_endo", "fibres.angle_epi", "fibres.dispersion_angle", "fibres.outflow"},
                  rule != "constant" && rule != "file",
                  otherwise});
  uses.push_back({{"fibres.rings"}, rule == "apicobasal", otherwise});
  uses.push_back({{"fibres.direction", "fibres.sheet"}, rule == "constant", otherwise});
  return uses;
}

std::vector<Use> uses_of_solvers(const SceneParameters &scene) {
  const auto &mech = scene.mech;
  const bool has_valves = is_in("mitral", geometry::fluid_labels(scene.geometry)) ||
                          is_in("aortic", geometry::fluid_labels(scene.geometry));
  return {
      {{"electrophysiology"}, takes_part(scene, {"ep_solver"}), "no ep_solver takes part"},
      {{"electrophysiology.integrator", "electrophysiology.substeps", "electrophysiology.substep_tolerance",
        "electrophysiology.tolerance", "electrophysiology.preconditioner"},
       scene.ep.model == "monodomain",
       "'electrophysiology.model' is " + scene.ep.model},
      {{"electrophysiology.conductivity", "electrophysiology.stimulus.sites", "electrophysiology.stimulus.amplitude",
        "electrophysiology.stimulus.duration"},
       scene.ep.model != "prescribed",
       "'electrophysiology.model' is prescribed"},
      {{"electrophysiology.eikonal"}, scene.ep.model == "eikonal", "'electrophysiology.model' is " + scene.ep.model},
      {{"electrophysiology.prescribed"},
       scene.ep.model == "prescribed",
       "'electrophysiology.model' is " + scene.ep.model},
      {{"mechanics"},
       takes_part(scene, {"mech_solver", "fsi_solver"}),
       "neither mech_solver nor fsi_solver takes part"},
      {{"lifting"}, takes_part(scene, {"ale_solver"}), "no ale_solver takes part"},
      {{"fluid"},
       takes_part(scene, {"fluid_solver", "fsi_solver", "cavity_solver"}),
       "neither fluid_solver nor fsi_solver takes part"},
      {{"fibres"}, takes_part(scene, {"ep_solver", "mech_solver", "fsi_solver"}), "nobody takes part who has fibres"},
      {{"mechanics.cavity_volume"}, mech.model == "prescribed", "'mechanics.model' is " + mech.model},
      {{"mechanics.law", "mechanics.regions", "mechanics.density", "mechanics.volume", "mechanics.inertia",
        "mechanics.active", "mechanics.pericardium", "mechanics.fixed", "mechanics.rollers",
        "mechanics.inflation_steps", "mechanics.loads", "mechanics.gravity", "mechanics.probes",
        "mechanics.active_increment", "mechanics.solver"},
       mech.model == "elastic",
       "'mechanics.model' is " + mech.model},
      {{"mechanics.active.tension_max", "mechanics.active.sarcomere_length"},
       is_in(mech.active.model, mech::force_model_names()),
       "'mechanics.active.model' is " + mech.active.model},
      {{"mechanics.active.tension", "mechanics.active.measure"},
       mech.active.model == "prescribed",
       "'mechanics.active.model' is " + mech.active.model},
      {{"mechanics.pericardium.K_perp", "mechanics.pericardium.K_par", "mechanics.pericardium.C_perp",
        "mechanics.pericardium.C_par"},
       !mech.pericardium.labels.empty(),
       "'mechanics.pericardium.labels' is empty"},
      {{"fluid.inlet.pressure"}, !scene.fluid.inlet.label.empty(), "'fluid.inlet.label' is empty"},
      {{"fluid.mitral_pressure", "fluid.aortic_pressure", "fluid.aortic_resistance", "fluid.valve_hysteresis",
        "fluid.valve_blanking", "fluid.mitral_guard", "fluid.backflow"},
       has_valves,
       "the shape " + scene.geometry.shape + " has no valves"},
      {{"coupling.epsilon"}, scene.coupling.scheme == "adaptive", "'coupling.scheme' is " + scene.coupling.scheme},
      {{"coupling.sequence"}, scene.coupling.is_written(), "'coupling.scheme' is " + scene.coupling.scheme},
      {{"coupling.alpha"},
       scene.coupling.has_robin_condition(),
       "'coupling.scheme' is " + scene.coupling.scheme + ", which has no Robin condition"},
  };
}

/// Of each law the wall, or a region of it, the parameters. A region takes those of the wall where it names none.
std::vector<Use> uses_of_laws(const mech::Parameters &mech) {
  std::vector<Use> uses;
  for (const auto &law : mech::law_names()) {
    bool is_used = mech.law == law;
    for (const auto &[name, region] : mech.regions) {
      const std::string block = "mechanics.regions." + name;
      uses.push_back({{block + "." + law}, region.law == law, "'" + block + ".law' is " + region.law});
      is_used |= region.law == law;
    }
    uses.push_back({{"mechanics." + law}, is_used, "'mechanics.law' is " + mech.law});
  }
  return uses;
}

std::vector<Use> all_uses(const SceneParameters &scene) {
  std::vector<Use> uses = uses_of_geometry(scene);
  for (const auto &more : {uses_of_solvers(scene), uses_of_laws(scene.mech)})
    uses.insert(uses.end(), more.begin(), more.end());
  return uses;
}

/// Why a key is not used ("'geometry.shape' is piston"); empty when it is, or when a program from elsewhere takes
/// part, which may use any.
std::string why_unused(const std::vector<Use> &uses, const std::string &path) {
  if (path == "electrophysiology" || path == "electrophysiology.stimulus" ||
      is_within(path, "electrophysiology.stimulus.period"))
    return ""; // the length of a beat, whoever computes the potential
  for (const Use &use : uses)
    for (const auto &block : use.blocks)
      if (!use.is_used && is_within(path, block))
        return use.otherwise;
  return "";
}

std::string last_word(const std::string &path) { return path.substr(path.rfind('.') + 1); }

/// Paths whose last word contains the key's, or is the same.
Words alike(const std::string &key, const Words &paths) {
  const std::string word = last_word(key);
  Words found;
  for (const auto &path : paths)
    if (path != key &&
        (last_word(path) == word || (word.size() > 3 && last_word(path).find(word) != std::string::npos)))
      found.push_back(path);
  return found;
}

/// The path, or the end of one as long as the key, that is spelled nearly so; empty when none is.
std::string nearest_end(const std::string &key, const Words &paths) {
  Words ends;
  const std::size_t n = std::count(key.begin(), key.end(), '.');
  for (const auto &path : paths) {
    std::size_t begin = path.size();
    for (std::size_t k = 0; k <= n && begin != std::string::npos; ++k)
      begin = begin == 0 ? std::string::npos : path.rfind('.', begin - 1);
    ends.push_back(begin == std::string::npos ? path : path.substr(begin + 1));
  }
  return config::nearest(key, ends);
}

/// What could be meant by a key: a few whose last word is alike, else, of a key that is unknown, the nearest one by
/// spelling.
std::string hint(const std::string &key, const Words &paths, bool is_known) {
  constexpr std::size_t few = 4;
  const Words found = alike(key, paths);
  if (!found.empty() && found.size() <= few)
    return "; did you mean " + config::joined(found) + "?";
  const std::string near = is_known ? "" : nearest_end(key, paths);
  return near.empty() ? "." : "; did you mean '" + near + "'?";
}

Words used_of(const SceneParameters &scene, const Words &paths) {
  const std::vector<Use> uses = all_uses(scene);
  Words used;
  std::copy_if(paths.begin(), paths.end(), std::back_inserter(used),
               [&](const auto &path) { return why_unused(uses, path).empty(); });
  return used;
}

/// All keys with this end; the key itself when it is whole.
Words matches(const std::string &key, const Words &paths) {
  if (is_in(key, paths))
    return {key};
  Words found;
  std::copy_if(paths.begin(), paths.end(), std::back_inserter(found),
               [&](const auto &path) { return has_end(path, key); });
  return found;
}

/// By which a key is told from all others that are used.
std::string shortest_end(const std::string &path, const Words &used) {
  for (std::size_t dot = path.rfind('.'); dot != std::string::npos && dot > 0; dot = path.rfind('.', dot - 1)) {
    const std::string end = path.substr(dot + 1);
    if (std::none_of(used.begin(), used.end(), [&](const auto &other) { return other != path && has_end(other, end); }))
      return end;
  }
  return path;
}

struct Setting {
  std::string key, value, words, path;
  Words candidates;
};

[[noreturn]] void refuse(const Setting &setting, const std::string &why) {
  throw Failure(ExitCode::scene, "--set " + setting.key + ": " + why);
}

Setting parsed(const std::string &text, const Words &paths) {
  const std::size_t sign = text.find('=');
  if (sign == std::string::npos || sign == 0)
    throw Failure(ExitCode::scene, "--set " + text + ": write key=value");
  Setting setting{text.substr(0, sign), text.substr(sign + 1), "--set " + text, "", {}};
  setting.candidates = matches(setting.key, paths);
  const bool is_free = is_within(setting.key, "participants"); // these may be new
  if (setting.candidates.empty() && is_free)
    setting.candidates = {setting.key};
  if (setting.candidates.empty())
    refuse(setting,
           "the key is unknown" + hint(setting.key, paths, false) + " 'coupler --print-defaults' lists all keys");
  return setting;
}

/// The scene as far as it is known: with a setting still missing it may contradict itself.
SceneParameters read_or(const SceneParameters &otherwise, const config::Node &root,
                        const std::function<SceneParameters(const config::Node &)> &read) {
  try {
    return read(root);
  } catch (const Failure &) {
    return otherwise;
  }
}

} // namespace

std::vector<Change> lay_over(config::Node &root, const Words &texts,
                             const std::function<SceneParameters(const config::Node &)> &read) {
  if (texts.empty())
    return {};
  SceneParameters scene = read(root);
  const Words paths = config::key_paths([&](config::Section &section) { scene.describe(section); });
  std::vector<Setting> settings;
  for (const auto &text : texts)
    settings.push_back(parsed(text, paths));
  const auto set = [&root](Setting &setting, const std::string &path) {
    setting.path = path;
    config::set_value(root, path, setting.value, setting.words);
  };
  for (Setting &setting : settings)
    if (setting.candidates.size() == 1)
      set(setting, setting.candidates[0]);
  const SceneParameters known = read_or(scene, root, read);
  for (Setting &setting : settings)
    if (setting.path.empty()) {
      const Words used = used_of(known, setting.candidates);
      if (used.size() > 1)
        refuse(setting, "the key is not unique; write one of " + config::joined(used));
      set(setting, used.empty() ? setting.candidates[0] : used[0]);
    }
  const SceneParameters whole = read(root);
  const std::vector<Use> uses = all_uses(whole);
  const Words used = used_of(whole, paths);
  std::vector<Change> changes;
  for (const Setting &setting : settings) {
    if (const std::string why = why_unused(uses, setting.path); !why.empty())
      refuse(setting, "this scene does not use '" + setting.path + "': " + why + hint(setting.path, used, true));
    changes.push_back({setting.path, shortest_end(setting.path, used), setting.value});
  }
  return changes;
}

} // namespace heartbus
