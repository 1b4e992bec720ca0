#include "coupler/sequence/notation.h"
#include "coupler/sequence/passes.h"
#include "coupler/sequence/vocabulary.h"

namespace heartbus::coupler {

namespace {

// Each scheme is a function: the lines of a step in the order and with the numbers of the paper's section 3. In which
// order they are done in a run is the business of passes.h. Symbols are those of docs/schemes.md.
// clang-format off

/// Everything once a step (section 3.1): the loosely coupled scheme.
Nodes EFS1() {
  return {solve("ep"),                                 // 1. v, w, z
          transfer("calcium", "ep", "mech"),
          prepare("mech"),                             // 2. s^{n+1}; v* and W* of d^n
          transfer("displacement", "mech", "ale"),
          solve("ale"),                                // 3. d_ALE^{n+1} = d^n on the interface
          transfer("mesh_motion", "ale", "fluid"),
          transfer("wall_velocity", "mech", "fluid"),
          transfer("wall_force", "mech", "fluid"),
          solve("fluid"),                              // 4. a_f(u, p) + alpha M u = alpha M v* - W*
          transfer("blood_force", "fluid", "mech"),
          solve("mech"),                               // 5. R_s(d^{n+1}) = L
          transfer("wall_velocity", "mech", "fluid"),
          order("fluid", "budget"),                    // what the new v leaves of volume and power
          commit("ep"), commit("mech"), commit("ale"), commit("fluid")};
}

/// Steps 4 and 5 k times (section 3.3). E1FS1 is EFS1; k -> infinity is the monolithic step.
Nodes E1FS(int k) {
  return {solve("ep"),                                             // 1. to 3. as EFS1
          transfer("calcium", "ep", "mech"),
          prepare("mech"),
          transfer("displacement", "mech", "ale"),
          solve("ale"),
          transfer("mesh_motion", "ale", "fluid"),
          repeat(k, {transfer("wall_velocity", "mech", "fluid"),   // v* and W* of d_(k)
                     transfer("wall_force", "mech", "fluid"),
                     solve("fluid"),                               // 4a. u_(k+1)
                     transfer("blood_force", "fluid", "mech"),
                     solve("mech")}),                              // 4b. d_(k+1)
          transfer("wall_velocity", "mech", "fluid"),
          order("fluid", "budget"),
          commit("ep"), commit("mech"), commit("ale"), commit("fluid")};
}

/// E1FSk whose k is found in each step: until a scalar of the blood, from its budget, is below a limit.
Nodes E1FS_until(const std::string &scalar, double limit, int at_most) {
  return {solve("ep"),                                             // 1. to 3. as EFS1
          transfer("calcium", "ep", "mech"),
          prepare("mech"),
          transfer("displacement", "mech", "ale"),
          solve("ale"),
          transfer("mesh_motion", "ale", "fluid"),
          until("fluid", scalar, limit, at_most,
                    {transfer("wall_velocity", "mech", "fluid"),
                     transfer("wall_force", "mech", "fluid"),
                     solve("fluid"),                               // 4a. u_(k+1)
                     transfer("blood_force", "fluid", "mech"),
                     solve("mech"),                                // 4b. d_(k+1)
                     transfer("wall_velocity", "mech", "fluid"),
                     order("fluid", "budget")}),
          commit("ep"), commit("mech"), commit("ale"), commit("fluid")};
}

/// Blood and wall at once, on the geometry of d^n (section 3.2): the monolithic step.
Nodes E1FSinf() {
  return {solve("ep"),                               // 1. as EFS1
          transfer("calcium", "ep", "fsi"),
          transfer("displacement", "fsi", "ale"),
          solve("ale"),                              // 3. as EFS1
          transfer("mesh_motion", "ale", "fsi"),
          solve("fsi"),                              // 2. as EFS1; 4. a_f(u, p) + R_s(d) = 0, u = (d - d^n)/dt
          commit("ep"), commit("ale"), commit("fsi")};
}

/// EFS1, then a pressure that is the same everywhere and moves the wall so that the cavity's volume is kept.
Nodes EFS1_corrected() {
  return after(EFS1(), solve("mech"),
               {order("fluid", "begin_correction"),
                transfer("blood_velocity", "fluid", "mech"),
                transfer("unit_pressure_force", "fluid", "mech"),
                order("mech", "correct"),                            // pi; d, L
                transfer("pressure_correction", "mech", "fluid"),
                order("fluid", "correct")});                         // p
}

/// Each physics alone, or after those it follows: nothing acts back. Calcium makes the wall contract, the wall's motion
/// moves the fluid's mesh, the blood moves with it.
Nodes one_way() {
  return {solve("ep"),
          if_wanted(transfer("calcium", "ep", "mech")),
          solve("mech"),
          if_wanted(transfer("displacement", "mech", "ale")),
          solve("ale"),
          if_wanted(transfer("mesh_motion", "ale", "fluid")),
          solve("fluid"),
          commit("ep"), commit("mech"), commit("ale"), commit("fluid")};
}

/// Blood of one pressure: the wall is solved under a guess of it; the circulation finds the pressure with the wall's
/// answer to a unit pressure, and the wall follows. Nothing is iterated and no volume lost.
Nodes circulation() {
  return {solve("ep"),
          transfer("calcium", "ep", "mech"),
          solve("mech"),
          transfer("cavity_volume", "mech", "circulation"),
          transfer("cavity_compliance", "mech", "circulation"),
          transfer("cavity_pressure_guess", "mech", "circulation"),
          solve("circulation"),
          transfer("cavity_pressure", "circulation", "mech"),
          order("mech", "press"),
          transfer("cavity_volume", "mech", "circulation"),
          order("circulation", "budget"),
          commit("ep"), commit("mech"), commit("circulation")};
}
// clang-format on

/// Before the first step: the wall inflated to the initial pressure, the fluid's mesh with it, blood at rest.
Nodes start(const std::string &wall, const std::string &blood) {
  return {order(wall, "inflate"), transfer("displacement", wall, "ale"), solve("ale"),
          transfer("mesh_motion", "ale", blood), order(blood, "start")};
}
Nodes one_way_start() {
  return {order("mech", "inflate"), if_wanted(transfer("displacement", "mech", "ale")), solve("ale"),
          if_wanted(transfer("mesh_motion", "ale", "fluid")), order("fluid", "start")};
}
Nodes circulation_start() {
  return {order("mech", "inflate"), transfer("cavity_volume", "mech", "circulation"), order("circulation", "start"),
          transfer("cavity_pressure", "circulation", "mech")};
}

/// Which nodes of the interface the wall holds, so that the blood holds the same. Another program's wall need not know.
Nodes constants() { return {optional(transfer("held", "mech", "fluid")), order("fluid", "hold")}; }

/// The run fails where the repetition does not end by itself.
Nodes must_end(Nodes step) {
  for (Node &node : step)
    node.required = node.kind == Node::Kind::until;
  return step;
}

/// The scheme's own lines of a step.
Nodes step_of(const CouplingParameters &coupling) {
  const std::string &scheme = coupling.scheme;
  if (scheme == "E1FS" && coupling.tolerance > 0) // until the Robin datum does not change any more
    return must_end(E1FS_until("datum_residual", coupling.tolerance, coupling.iterations));
  if (scheme == "E1FS")
    return E1FS(coupling.iterations);
  if (scheme == "adaptive") // until the step keeps the cavity's volume
    return E1FS_until("volume_loss", coupling.epsilon, coupling.iterations);
  if (scheme == "by_phase") // more than once while all valves are closed
    return E1FS_until("isovolumetric", 0.5, coupling.iterations);
  return scheme == "EFS1" ? EFS1() : EFS1_corrected();
}

} // namespace

Sequence scheme(const CouplingParameters &coupling) {
  if (coupling.is_written())
    return parse(coupling.sequence);
  if (coupling.scheme == "E1FSinf")
    return {coupling.scheme, start("fsi", "fsi"), E1FSinf()};
  if (coupling.scheme == "one_way")
    return {coupling.scheme, one_way_start(), one_way(), constants()};
  if (coupling.scheme == "circulation")
    return {coupling.scheme, circulation_start(), circulation()};
  return {coupling.scheme, start("mech", "fluid"), step_of(coupling), constants()};
}

std::map<std::string, interface::Texts> interface_settings(const SceneParameters &scene) {
  const CouplingParameters &coupling = scene.coupling;
  const bool follows = !coupling.has_robin_condition();
  interface::BloodSettings blood;
  blood.condition = follows ? interface::BloodSettings::Condition::motion : interface::BloodSettings::Condition::robin;
  blood.alpha = coupling.automatic_alpha ? 0 : coupling.alpha;
  interface::WallSettings wall;
  wall.load = scene.has("circulation")         ? interface::WallSettings::Load::cavity_pressure
              : scene.has("fluid") && !follows ? interface::WallSettings::Load::blood_force
                                               : interface::WallSettings::Load::initial_pressure;
  blood.alternation = wall.alternation =
      coupling.repeats() ? interface::Alternation::iterations : interface::Alternation::steps;
  return {{"fluid", to_texts(blood)}, {"mech", to_texts(wall)}};
}

Sequence make_sequence(const CouplingParameters &coupling, double dt) {
  Sequence sequence = scheme(coupling);
  if (coupling.acceleration == "anderson")
    sequence.step = accelerated(sequence.step);
  sequence.step = with_limit_of_alpha(lifted_early(sequence.step), coupling.automatic_alpha, dt);
  sequence.start = with_first_limit(sequence.start, sequence.step);
  if (coupling.lookahead == 0)
    sequence.step = in_turns(sequence.step);
  return sequence;
}

} // namespace heartbus::coupler
