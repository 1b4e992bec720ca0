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
Node repeat(int times, const Nodes &body) { return {Node::Kind::repeat, "", "", "", "", times, body}; }

// Before the first step: the wall inflated to the initial pressure, the fluid's mesh with it, blood at rest.
Nodes start() {
  return {order("mech", "inflate"), transfer("displacement", "mech", "ale"), solve("ale"),
          transfer("mesh_motion", "ale", "fluid"), order("fluid", "start")};
}

/// The loosely coupled scheme of the paper: electrophysiology, active force, the fluid's mesh moved by d^n (explicit
/// geometry), the fluid with a Robin condition on the wall, the wall with the blood's force. Last, the budget: what the
/// wall's new velocity leaves of volume and power.
Nodes EFS1() {
  return {
      solve("ep"),
      transfer("calcium", "ep", "mech"),
      prepare("mech"),
      transfer("displacement", "mech", "ale"),
      solve("ale"),
      transfer("mesh_motion", "ale", "fluid"),
      transfer("wall_velocity", "mech", "fluid"),
      transfer("wall_force", "mech", "fluid"),
      solve("fluid"),
      transfer("blood_force", "fluid", "mech"),
      solve("mech"),
      transfer("wall_velocity", "mech", "fluid"),
      order("fluid", "budget"),
      commit("ep"),
      commit("mech"),
      commit("ale"),
      commit("fluid"),
  };
}

/// E1FSk: fluid and wall are solved k times, each time with the wall's last velocity and the blood's last force in the
/// Robin condition. E1FS1 is EFS1; k -> infinity is the monolithic step.
Nodes E1FS(int k) {
  return {
      solve("ep"),
      transfer("calcium", "ep", "mech"),
      prepare("mech"),
      transfer("displacement", "mech", "ale"),
      solve("ale"),
      transfer("mesh_motion", "ale", "fluid"),
      repeat(k,
             {
                 transfer("wall_velocity", "mech", "fluid"),
                 transfer("wall_force", "mech", "fluid"),
                 solve("fluid"),
                 transfer("blood_force", "fluid", "mech"),
                 solve("mech"),
             }),
      transfer("wall_velocity", "mech", "fluid"),
      order("fluid", "budget"),
      commit("ep"),
      commit("mech"),
      commit("ale"),
      commit("fluid"),
  };
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

/// Contraction without blood: calcium makes the wall contract.
Nodes electromechanics() {
  return {
      solve("ep"), transfer("calcium", "ep", "mech"), solve("mech"), commit("ep"), commit("mech"),
  };
}

} // namespace

Sequence make_sequence(const std::string &scheme, int iterations) {
  if (scheme == "EFS1")
    return {scheme, start(), EFS1()};
  if (scheme == "E1FS")
    return {scheme + " with k = " + std::to_string(iterations), start(), E1FS(iterations)};
  if (scheme == "E1FSinf")
    return {scheme, merged_start(), E1FSinf()};
  return {scheme, start(), electromechanics()};
}

} // namespace heartbus::coupler
