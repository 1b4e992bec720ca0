#include "coupler/sequence/passes.h"

#include "common/interface/alpha.h"
#include "coupler/sequence/vocabulary.h"

#include <algorithm>
#include <utility>

namespace heartbus::coupler {
namespace {

using Place = Nodes::const_iterator;

Place find_transfer(const Nodes &step, const std::string &field) {
  return std::find_if(step.begin(), step.end(), [&](const Node &node) { return is_transfer(node, field); });
}

} // namespace

Nodes accelerated(const Nodes &step) {
  Nodes result;
  for (Node node : step) {
    for (const Node &line : std::exchange(node.body, {})) {
      if (is(line, Node::Kind::solve, "fluid"))
        node.body.push_back(order("fluid", "accelerate"));
      node.body.push_back(line);
    }
    result.push_back(node);
  }
  return result;
}

Nodes lifted_early(const Nodes &step) {
  const Place displacement = find_transfer(step, "displacement"), motion = find_transfer(step, "mesh_motion");
  if (displacement == step.end() || motion == step.end() || displacement->participant == motion->receiver)
    return step; // the fluid's mesh rests, or wall and blood are prepared as one, which takes calcium
  const bool is_of_this_step = std::any_of(step.begin(), displacement, [&](const Node &node) {
    return is(node, Node::Kind::solve, displacement->participant);
  });
  if (is_of_this_step)
    return step;
  Nodes first, others;
  for (const Node &node : step) {
    const bool lifts = is_transfer(node, "displacement") || is(node, Node::Kind::solve, motion->participant) ||
                       is_transfer(node, "mesh_motion");
    (lifts ? first : others).push_back(node);
  }
  return first + Nodes{prepare(motion->receiver)} + others;
}

Nodes with_limit_of_alpha(const Nodes &step, bool is_followed, double dt) {
  const Place motion = find_transfer(step, "mesh_motion");
  const auto actions = flatten(step);
  const bool has_robin_condition = std::any_of(
      actions.begin(), actions.end(), [](const Action &action) { return is_transfer(action.node, "wall_velocity"); });
  if (motion == step.end() || !has_robin_condition)
    return step;
  const Nodes one_force{optional(transfer("probe_force", "mech", "fluid")), order("fluid", "probe"),
                        optional(transfer("probe_velocity", "fluid", "mech")), order("mech", "probe")};
  const Nodes estimate{order("mech", "begin_probe"), order("fluid", "begin_probe"),
                       repeat(interface::n_probes, one_force), order("mech", "end_probe")};
  const int steps = interface::steps_between_estimates(is_followed, dt);
  const Node now_and_then = every(steps, "mech", "alpha_limit", estimate);
  const Node limit = transfer("alpha_limit", "mech", "fluid");
  return after(step, *motion,
               is_followed ? Nodes{now_and_then, limit, order("fluid", "follow_limit")}
                           : Nodes{now_and_then, optional(limit)});
}

Nodes with_first_limit(const Nodes &start, const Nodes &step) {
  const Place estimate = std::find_if(step.begin(), step.end(), [](const Node &node) {
    return node.kind == Node::Kind::every && node.field == "alpha_limit";
  });
  const Place fluid_starts = std::find_if(
      start.begin(), start.end(), [](const Node &node) { return node.participant == "fluid" && node.task == "start"; });
  return estimate == step.end() || fluid_starts == start.end() ? start : after(start, *fluid_starts, {*estimate});
}

Nodes in_turns(const Nodes &step) {
  const Place work =
      std::find_if(step.begin(), step.end(), [](const Node &node) { return is(node, Node::Kind::solve, "ep"); });
  const Place assembly =
      std::find_if(step.begin(), work, [](const Node &node) { return is(node, Node::Kind::prepare, "fluid"); });
  if (assembly != work)
    return after(step, *assembly, {turn("fluid", "ep")});
  const Place calcium = find_transfer(step, "calcium");
  return calcium == step.end() ? step : step + Nodes{turn(calcium->receiver, "ep", 1)};
}

Sequence ordered_ahead(Sequence sequence, int steps) {
  sequence.ahead = steps;
  sequence.source_participants = source_participants(sequence.step);
  return sequence;
}

} // namespace heartbus::coupler
