#include "coupler/sequence/sequence.h"

#include <algorithm>
#include <map>
#include <set>

namespace heartbus::coupler {

namespace {

/// At the line's place if the scene has it.
[[noreturn]] void refuse(const Sequence &sequence, const Node &node, const std::string &message) {
  throw Failure(ExitCode::handshake, (node.where.empty() ? "" : node.where + ": ") + "the scheme " + sequence.name +
                                         " does not fit this run: " + message);
}

/// Who else has an output of this name; empty if nobody.
std::string offered_by(const bus::FieldInfo &input, const bus::ParticipantInfo &reader,
                       const std::vector<bus::ParticipantInfo> &participants) {
  const auto is_it = [&](const bus::FieldInfo &field) { return field.output && field.name == input.name; };
  for (const auto &other : participants)
    if (other.name != reader.name && std::any_of(other.fields.begin(), other.fields.end(), is_it))
      return other.name;
  return "";
}

Node last_of_the_scene(const std::vector<Action> &step) {
  const auto last =
      std::find_if(step.rbegin(), step.rend(), [](const Action &action) { return !action.node.where.empty(); });
  return last == step.rend() ? Node{} : last->node;
}

void check_commits(const Sequence &sequence, const std::vector<Action> &step,
                   const std::vector<bus::ParticipantInfo> &participants) {
  std::map<std::string, int> solves, commits;
  for (const auto &[node, iteration] : step) {
    if (node.kind == Node::Kind::turn)
      continue;
    const bool late =
        commits.count(node.participant) || (node.kind == Node::Kind::transfer && commits.count(node.receiver));
    if (late)
      refuse(sequence, node, "'" + node.participant + "' is busy after its commit, which must be its last line");
    solves[node.participant] += node.kind == Node::Kind::solve;
    if (node.kind == Node::Kind::commit)
      ++commits[node.participant];
  }
  for (const auto &participant : participants)
    if (solves[participant.name] == 0 || commits[participant.name] != 1)
      refuse(sequence, last_of_the_scene(step),
             "'" + participant.name + "' must be solved and committed in each step, but is solved " +
                 std::to_string(solves[participant.name]) + " and committed " +
                 std::to_string(commits[participant.name]) + " times");
}

std::string deed(const Node &node) { return node.kind == Node::Kind::solve ? "is solved" : "does '" + node.task + "'"; }

/// `received`: what the participant has got before this line of its.
void check_inputs(const Sequence &sequence, const Node &node, const std::vector<bus::ParticipantInfo> &participants,
                  const std::set<std::string> &received) {
  for (const auto &participant : participants)
    for (const auto &field : participant.fields) {
      const bool is_read = participant.name == node.participant && !field.output && field.level == node.task;
      const std::string sender = is_read ? offered_by(field, participant, participants) : "";
      if (!sender.empty() && !received.count(field.name))
        refuse(sequence, node,
               "'" + participant.name + "' " + deed(node) + " before it has received '" + field.name + "': '" +
                   field.name + " " + sender + "->" + participant.name + "' comes first");
    }
}

void check_fields(const Sequence &sequence, const std::vector<Action> &actions,
                  const std::vector<bus::ParticipantInfo> &participants) {
  std::map<std::string, std::set<std::string>> received;
  for (const auto &[node, iteration] : flatten(sequence.constants)) // nobody has to compute them
    if (node.kind == Node::Kind::transfer)
      received[node.receiver].insert(node.field);
  std::set<std::string> active; // who has computed something that can be sent
  for (const auto &[node, iteration] : actions) {
    if (node.kind == Node::Kind::turn)
      continue;
    if (node.kind == Node::Kind::transfer) {
      if (!active.count(node.participant))
        refuse(sequence, node,
               "'" + node.field + "' is sent before '" + node.participant + "' has computed it: 'solve " +
                   node.participant + "' comes first");
      received[node.receiver].insert(node.field);
      continue;
    }
    active.insert(node.participant);
    if (node.kind != Node::Kind::solve && node.kind != Node::Kind::task)
      continue;
    check_inputs(sequence, node, participants, received[node.participant]);
  }
}

} // namespace

void check(const Sequence &sequence, const std::vector<bus::ParticipantInfo> &participants) {
  std::vector<Action> actions = flatten(sequence.start), step = flatten(sequence.step);
  check_commits(sequence, step, participants);
  actions.insert(actions.end(), step.begin(), step.end());
  check_fields(sequence, actions, participants);
}

} // namespace heartbus::coupler
