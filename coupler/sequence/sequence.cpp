#include "coupler/sequence/sequence.h"

#include "common/units/units.h"

#include <algorithm>

namespace heartbus::coupler {

namespace {

const bus::ParticipantInfo *find(const std::vector<bus::ParticipantInfo> &participants, const std::string &name) {
  for (const auto &participant : participants)
    if (participant.name == name)
      return &participant;
  return nullptr;
}

bool knows(const bus::ParticipantInfo &participant, const std::string &field, bool output) {
  return std::any_of(participant.fields.begin(), participant.fields.end(),
                     [&](const auto &f) { return f.name == field && f.output == output; });
}

bool is_known_to_both(const Node &transfer, const std::vector<bus::ParticipantInfo> &participants) {
  return knows(*find(participants, transfer.participant), transfer.field, true) &&
         knows(*find(participants, transfer.receiver), transfer.field, false);
}

bool are_there(const Node &node, const std::vector<bus::ParticipantInfo> &participants) {
  return find(participants, node.participant) && (node.receiver.empty() || find(participants, node.receiver));
}

bool applies(const Node &node, const std::vector<bus::ParticipantInfo> &participants) {
  const bool has_body =
      node.kind == Node::Kind::repeat || node.kind == Node::Kind::until || node.kind == Node::Kind::every;
  if (has_body && node.body.empty())
    return false;
  if (node.kind == Node::Kind::repeat)
    return true;
  if (!are_there(node, participants))
    return false;
  if (node.kind == Node::Kind::transfer)
    return is_known_to_both(node, participants);
  const auto &tasks = find(participants, node.participant)->tasks;
  return node.kind != Node::Kind::task || std::find(tasks.begin(), tasks.end(), node.task) != tasks.end();
}

Nodes drop_absent(const Nodes &nodes, const std::vector<bus::ParticipantInfo> &participants) {
  Nodes kept;
  for (Node node : nodes) {
    const std::size_t n_actions = flatten(node.body).size();
    node.body = drop_absent(node.body, participants);
    if (node.kind == Node::Kind::every && flatten(node.body).size() < n_actions)
      continue;
    if (applies(node, participants))
      kept.push_back(node);
  }
  return kept;
}

/// "blood_force from fluid to mech (mech does not take it)": what the scheme needs and nobody will send.
std::set<std::string> missing_in(const Nodes &nodes, const std::vector<bus::ParticipantInfo> &participants) {
  std::set<std::string> missing;
  for (const auto &[node, iteration] : flatten(nodes))
    if (node.kind == Node::Kind::transfer && !node.optional && are_there(node, participants) &&
        !is_known_to_both(node, participants)) {
      const bool is_sent = knows(*find(participants, node.participant), node.field, true);
      missing.insert(
          "'" + node.field + "' from " + node.participant + " to " + node.receiver + " (" +
          (is_sent ? node.receiver + " declares no such input" : node.participant + " declares no such output") + ")");
    }
  return missing;
}

void write_out(const Nodes &nodes, int &iteration, std::vector<Action> &actions) {
  for (const Node &node : nodes)
    if (node.kind == Node::Kind::repeat)
      for (int i = 0; i < node.times; ++i) {
        iteration = i;
        write_out(node.body, iteration, actions);
      }
    else if (node.kind == Node::Kind::until)
      write_out(node.body, iteration, actions);
    else if (node.kind == Node::Kind::every) {
      int its_own = 0;
      write_out(node.body, its_own, actions);
    } else
      actions.push_back({node, iteration});
}

/// Of a node with a body what precedes that.
std::string head_of(const Node &node) {
  switch (node.kind) {
  case Node::Kind::prepare:
    return "prepare " + node.participant;
  case Node::Kind::solve:
    return "solve " + node.participant;
  case Node::Kind::commit:
    return "commit " + node.participant;
  case Node::Kind::task:
    return node.task + " " + node.participant;
  case Node::Kind::transfer:
    return node.field + " " + node.participant + "->" + node.receiver;
  case Node::Kind::repeat:
    return std::to_string(node.times) + " times";
  case Node::Kind::until:
    return "until " + node.field + " of " + node.participant + " < " + config::shortest(node.limit) + ", at most " +
           std::to_string(node.times) + " times";
  case Node::Kind::every:
    return "every " + std::to_string(node.times) + " steps";
  case Node::Kind::turn:
    return "then " + node.receiver + (node.times > 0 ? " goes on with the next step" : " goes on");
  }
  return "";
}

std::string to_text(const Nodes &nodes) {
  std::string text;
  for (const Node &node : nodes)
    text += (text.empty() ? "" : "; ") + head_of(node) + (node.body.empty() ? "" : " (" + to_text(node.body) + ")");
  return text;
}

} // namespace

Sequence drop_absent(const Sequence &sequence, const std::vector<bus::ParticipantInfo> &participants) {
  std::set<std::string> missing = missing_in(sequence.start, participants);
  missing.merge(missing_in(sequence.step, participants));
  std::string list;
  for (const std::string &field : missing)
    list += (list.empty() ? "" : ", ") + field;
  if (!missing.empty())
    throw Failure(ExitCode::handshake, "the scheme " + sequence.name + " needs " + list);
  Sequence kept = sequence;
  for (Nodes *nodes : {&kept.start, &kept.step, &kept.constants})
    *nodes = drop_absent(*nodes, participants);
  return kept;
}

std::vector<Action> flatten(const Nodes &nodes, int first_iteration) {
  std::vector<Action> actions;
  write_out(nodes, first_iteration, actions);
  return actions;
}

std::set<std::string> source_participants(const Nodes &step) {
  std::set<std::string> leading;
  for (const auto &[node, iteration] : flatten(step))
    leading.insert(node.participant);
  for (const auto &[node, iteration] : flatten(step))
    leading.erase(node.receiver);
  for (const Node &node : step)
    if (node.kind == Node::Kind::until || node.kind == Node::Kind::every)
      for (const auto &[inner, iteration] : flatten(node.body))
        leading.erase(inner.participant);
  return leading;
}

std::string to_lines(const Nodes &nodes, const std::string &indent) {
  std::string text;
  for (const Node &node : nodes)
    text += "\n" + indent + head_of(node) + to_lines(node.body, indent + "  ");
  return text;
}

std::string to_text(const Sequence &sequence) {
  const std::string constants = sequence.constants.empty() ? "" : "\n  once:  " + to_text(sequence.constants);
  const std::string start = sequence.start.empty() ? "" : "\n  start: " + to_text(sequence.start);
  return sequence.name + constants + start + "\n  step:  " + to_text(sequence.step);
}

} // namespace heartbus::coupler
