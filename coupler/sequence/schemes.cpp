#include "coupler/sequence/sequence.h"

namespace heartbus::coupler {

namespace {

// The vocabulary of a scheme.
Node solve(const std::string &who) { return {Node::Kind::solve, who, "", "", "", 1, {}}; }
Node prepare(const std::string &who) { return {Node::Kind::prepare, who, "", "", "", 1, {}}; }
Node commit(const std::string &who) { return {Node::Kind::commit, who, "", "", "", 1, {}}; }
Node order(const std::string &who, const std::string &task) { return {Node::Kind::task, who, task, "", "", 1, {}}; }
Node transfer(const std::string &field, const std::string &from, const std::string &to) {
  return {Node::Kind::transfer, from, "", to, field, 1, {}};
}
Node turn(const std::string &from, const std::string &to, int steps_later = 0) {
  return {Node::Kind::turn, from, "", to, "", steps_later, {}};
}
Node repeat(int times, const Nodes &body) { return {Node::Kind::repeat, "", "", "", "", times, body}; }
Node until(const std::string &who, const std::string &scalar, double limit, int at_most, const Nodes &body) {
  return {Node::Kind::until, who, "", "", scalar, at_most, body, limit};
}
Node every(int steps, const std::string &who, const std::string &scalar, const Nodes &body) {
  return {Node::Kind::every, who, "", "", scalar, steps, body};
}
Node required(Node node) {
  node.required = true;
  return node;
}
Node optional(Node node) {
  node.optional = true;
  return node;
}
Nodes operator+(Nodes first, const Nodes &second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

// Which nodes of the interface the wall holds, so that the blood holds the same. Another program's wall need not know.
Nodes constants() { return {optional(transfer("held", "mech", "fluid")), order("fluid", "hold")}; }

// Before the first step: the wall inflated to the initial pressure, the fluid's mesh with it, blood at rest.
Nodes start() {
  return {order("mech", "inflate"), transfer("displacement", "mech", "ale"), solve("ale"),
          transfer("mesh_motion", "ale", "fluid"), order("fluid", "start")};
}

// What precedes fluid and wall in each step: the fluid's mesh moved by d^n (explicit geometry), how large alpha may be
// (now and then), electrophysiology and active force.
Nodes geometry() {
  return {transfer("displacement", "mech", "ale"), solve("ale"), transfer("mesh_motion", "ale", "fluid")};
}
Nodes activation() { return {solve("ep"), transfer("calcium", "ep", "mech"), prepare("mech")}; }

/// The limit of alpha, which changes by some percent in a hundred steps (a fixed alpha only compares itself with it):
/// the wall probes with one force after the other how it moves itself and how the blood yields, until it knows the most
/// compliant motion (mech_solver/interface_impedance.h).
Nodes limit(bool is_followed) {
  const Nodes one_force{optional(transfer("probe_force", "mech", "fluid")), order("fluid", "probe"),
                        optional(transfer("probe_velocity", "fluid", "mech")), order("mech", "probe")};
  const Nodes estimate{order("mech", "begin_probe"), repeat(12, one_force), order("mech", "end_probe")};
  const Node known = transfer("alpha_limit", "mech", "fluid");
  return {every(is_followed ? 100 : 1000, "mech", "alpha_limit", estimate), is_followed ? known : optional(known)};
}

/// Once fluid and wall: the fluid with a Robin condition made of the wall's last velocity and force, the wall with the
/// blood's force.
Nodes blood_and_wall() {
  return {transfer("wall_velocity", "mech", "fluid"), transfer("wall_force", "mech", "fluid"), solve("fluid"),
          transfer("blood_force", "fluid", "mech"), solve("mech")};
}

/// What the wall's new velocity leaves of volume and power.
Nodes budget() { return {transfer("wall_velocity", "mech", "fluid"), order("fluid", "budget")}; }

Nodes commit() { return {commit("ep"), commit("mech"), commit("ale"), commit("fluid")}; }

/// The loosely coupled scheme of the paper: fluid and wall once a step.
Nodes EFS1() { return blood_and_wall() + budget(); }

/// E1FSk: fluid and wall k times. E1FS1 is EFS1; k -> infinity is the monolithic step.
Nodes E1FS(int k) { return Nodes{repeat(k, blood_and_wall())} + budget(); }

/// E1FSk with as many iterations as it takes until the Robin datum does not change any more.
Nodes E1FS(int at_most, double tolerance) {
  return {required(until("fluid", "datum_residual", tolerance, at_most, blood_and_wall() + budget()))};
}

/// As many iterations as it takes until the step keeps the cavity's volume.
Nodes adaptive(int at_most, double epsilon) {
  return {until("fluid", "volume_loss", epsilon, at_most, blood_and_wall() + budget())};
}

/// E1FSk while all valves are closed, EFS1 otherwise.
Nodes by_phase(int k) { return {until("fluid", "isovolumetric", 0.5, k, blood_and_wall() + budget())}; }

/// EFS1, then a pressure that is the same everywhere and moves the wall so that the cavity's volume is kept.
Nodes EFS1_corrected() {
  return Nodes{transfer("wall_velocity", "mech", "fluid"),
               transfer("wall_force", "mech", "fluid"),
               solve("fluid"),
               transfer("blood_force", "fluid", "mech"),
               transfer("blood_velocity", "fluid", "mech"),
               transfer("unit_pressure_force", "fluid", "mech"),
               solve("mech"),
               order("mech", "correct"),
               transfer("pressure_correction", "mech", "fluid"),
               order("fluid", "correct")} +
         budget();
}

// The same with wall and blood in one participant.
Nodes merged_start() {
  return {order("fsi", "inflate"), transfer("displacement", "fsi", "ale"), solve("ale"),
          transfer("mesh_motion", "ale", "fsi"), order("fsi", "start")};
}

/// E1FS-infinity: the geometry is that of d^n as before, but blood and wall are solved at once.
Nodes E1FSinf() {
  return {
      solve("ep"),
      transfer("calcium", "ep", "fsi"),
      transfer("displacement", "fsi", "ale"),
      solve("ale"),
      transfer("mesh_motion", "ale", "fsi"),
      solve("fsi"),
      commit("ep"),
      commit("ale"),
      commit("fsi"),
  };
}

/// Each physics alone, or after those it follows: nothing acts back. Calcium makes the wall contract, the wall's motion
/// moves the fluid's mesh, the blood moves with it.
Nodes one_way_start() {
  return {order("mech", "inflate"), optional(transfer("displacement", "mech", "ale")), solve("ale"),
          optional(transfer("mesh_motion", "ale", "fluid")), order("fluid", "start")};
}
Nodes one_way() {
  return Nodes{solve("ep"),
               optional(transfer("calcium", "ep", "mech")),
               solve("mech"),
               optional(transfer("displacement", "mech", "ale")),
               solve("ale"),
               optional(transfer("mesh_motion", "ale", "fluid")),
               solve("fluid")} +
         commit();
}

/// Blood of one pressure: the wall is solved under a guess of it; the circulation finds the pressure with the wall's
/// answer to a unit pressure, and the wall follows. Nothing is iterated and no volume lost.
Nodes circulation_start() {
  return {order("mech", "inflate"), transfer("cavity_volume", "mech", "circulation"), order("circulation", "start"),
          transfer("cavity_pressure", "circulation", "mech")};
}
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
          commit("ep"),
          commit("mech"),
          commit("circulation")};
}

Nodes interaction(const CouplingParameters &coupling) {
  if (coupling.scheme == "E1FS")
    return coupling.tolerance > 0 ? E1FS(coupling.iterations, coupling.tolerance) : E1FS(coupling.iterations);
  if (coupling.scheme == "adaptive")
    return adaptive(coupling.iterations, coupling.epsilon);
  if (coupling.scheme == "by_phase")
    return by_phase(coupling.iterations);
  return coupling.scheme == "EFS1" ? EFS1() : EFS1_corrected();
}

} // namespace

Sequence make_sequence(const CouplingParameters &coupling) {
  // Two solvers at a time are slower on shared cores than one after the other; so electrophysiology takes turns there.
  const auto ep_after = [&](const std::string &who, int steps_later = 0) {
    return coupling.lookahead > 0 ? Nodes{} : Nodes{turn(who, "ep", steps_later)};
  };
  if (coupling.scheme == "E1FSinf")
    return {coupling.scheme, merged_start(), E1FSinf() + ep_after("fsi", 1)};
  if (coupling.scheme == "one_way")
    return {coupling.scheme, one_way_start(), one_way() + ep_after("mech", 1), constants()};
  if (coupling.scheme == "circulation")
    return {coupling.scheme, circulation_start(), circulation() + ep_after("mech", 1)};
  // Lifting and the fluid's assembly need neither calcium nor tension. They go first: beside electrophysiology on cores
  // of their own; on shared ones lifting begins while the fluid still commits the step before.
  const Nodes before = geometry() + limit(coupling.automatic_alpha) + Nodes{prepare("fluid")} + ep_after("fluid");
  const Nodes no_correction{transfer("pressure_correction", "mech", "fluid")};
  return {coupling.scheme, coupling.scheme == "EFS1-corrected" ? start() + no_correction : start(),
          before + activation() + interaction(coupling) + commit(), constants()};
}

} // namespace heartbus::coupler
