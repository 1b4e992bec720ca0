#pragma once

#include "ale_solver/parameters.h"
#include "common/config/node.h"
#include "common/config/section.h"
#include "common/geometry/parameters.h"
#include "ep_solver/parameters.h"
#include "fluid_solver/parameters.h"
#include "mech_solver/parameters.h"

#include <map>
#include <string>
#include <vector>

namespace heartbus {

/// A run is so many beats long, each of one period of the stimulus, or ends at a time of its own.
struct TimeParameters {
  int beats = 1;             ///< of the run; 0: `end` was given instead
  bool whole_beats = true;   ///< the end is that of the last beat
  double end = 0.8;          ///< [s]
  double period = 0.8;       ///< of a beat: from one stimulus to the next [s]
  double until_periodic = 0; ///< share by which beats in a row may differ for the run to end; 0: it does not end early
  double step = 0.2e-3;      ///< [s]
  int n_steps() const;
  void describe(config::Section &section);
  /// Once the period is known: the end of the last beat. Fails on what contradicts itself.
  void settle(config::Section &section, double stimulus_period);
};

/// The schemes are explained in docs/schemes.md.
struct CouplingParameters {
  std::string scheme = "EFS1";       ///< EFS1, EFS1-corrected, E1FS, adaptive, by_phase, E1FSinf, one_way
  int iterations = 1;                ///< k of E1FSk; of adaptive the most, of by_phase while isovolumetric
  double tolerance = 0;              ///< of E1FS: iterates until the Robin datum changes less than this; 0: always k
  std::string acceleration = "none"; ///< of the iterations: none, anderson
  double epsilon = 1e-5;             ///< of adaptive: share of the cavity's volume that a step may lose
  double alpha = 5000;               ///< Robin coefficient of the fluid at the interface [kg/(m^2 s)]
  bool automatic_alpha = false;      ///< in place of `alpha`: a share of the limit that wall and blood set
  int lookahead = 0;                 ///< steps by which those who receive nothing may run ahead
  double deadline = 300;             ///< longest wait for anybody [s]
  /// Whether blood and wall may be solved more than once in a step.
  bool iterates() const { return scheme == "E1FS" || scheme == "adaptive" || scheme == "by_phase"; }
  /// Whether they are: then it is iterations that too large an alpha makes diverge, else motions that alternate from
  /// step to step.
  bool repeats() const { return iterates() && iterations > 1; }
  void describe(config::Section &section);
};

struct ParticipantParameters {
  std::string program; ///< name of an executable, beside the coupler or on the PATH, or its path; or
  std::string command; ///< a program of any kind with its words, as a shell takes them
  int ranks = 1;
  std::map<std::string, std::string> settings; ///< free keys for it, the values as written
  void describe(config::Section &section);
};

struct CheckpointParameters {
  double every = 50e-3; ///< interval between checkpoints [s]; 0: only at the end or when the run is stopped
  int keep = 2;         ///< how many remain
  void describe(config::Section &section);
};

struct OutputParameters {
  double every = 10e-3; ///< interval between written fields [s]; 0: none
  CheckpointParameters checkpoint;
  bool trace = false; ///< trace.json: what every rank does when
  /// Whether fields are written after this step (0 is the start block).
  bool due(int step_number, double step_size) const;
  void describe(config::Section &section);
};

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
