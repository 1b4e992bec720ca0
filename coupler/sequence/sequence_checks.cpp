#include "coupler/sequence/sequence.h"

#include <algorithm>
#include <map>
#include <set>

namespace heartbus::coupler {

namespace {

[[noreturn]] void refuse(const Sequence &sequence, const std::string &message) {
  throw Failure(ExitCode::handshake, "the scheme " + sequence.name + " does not fit this run: " + message);
}

bool offered_by_another(const bus::FieldInfo &input, const bus::ParticipantInfo &reader,
                        const std::vector<bus::ParticipantInfo> &participants) {
  return std::any_of(participants.begin(), participants.end(), [&](const bus::ParticipantInfo &other) {
    return other.name != reader.name && std::any_of(other.fields.begin(), other.fields.end(), [&](const auto &field) {
             return field.output && field.name == input.name;
           });
  });
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
      refuse(sequence, "'" + node.participant + "' is busy after its commit");
    solves[node.participant] += node.kind == Node::Kind::solve;
    if (node.kind == Node::Kind::commit)
      ++commits[node.participant];
  }
  for (const auto &participant : participants)
    if (solves[participant.name] == 0 || commits[participant.name] != 1)
      refuse(sequence, "'" + participant.name + "' must be solved and committed in each step, but has no part in it");
}

std::string deed(const Node &node) { return node.kind == Node::Kind::solve ? "is solved" : "does '" + node.task + "'"; }

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
        refuse(sequence, "'" + node.field + "' is sent before '" + node.participant + "' has computed it");
      received[node.receiver].insert(node.field);
      continue;
    }
    active.insert(node.participant);
    if (node.kind != Node::Kind::solve && node.kind != Node::Kind::task)
      continue;
    for (const auto &participant : participants)
      if (participant.name == node.participant)
        for (const auto &field : participant.fields)
          if (!field.output && field.level == node.task && !received[participant.name].count(field.name) &&
              offered_by_another(field, participant, participants))
            refuse(sequence,
                   "'" + participant.name + "' " + deed(node) + " before it has received '" + field.name + "'");
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
