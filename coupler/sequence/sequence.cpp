#include "coupler/sequence/sequence.h"

#include "common/units/nearest.h"

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

bool may_be_left_out(const Node &transfer, const std::vector<bus::ParticipantInfo> &participants) {
  return transfer.optional ||
         (transfer.if_wanted && !knows(*find(participants, transfer.receiver), transfer.field, false));
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

template <class Things>
std::vector<std::string> names_of(const Things &things) {
  std::vector<std::string> names;
  for (const auto &thing : things)
    names.push_back(thing.name);
  return names;
}

bool is_in(const std::string &word, const std::vector<std::string> &words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

std::string hint(const std::string &word, const std::vector<std::string> &known) {
  const std::string near = config::nearest(word, known);
  return near.empty() ? "" : "; did you mean '" + near + "'?";
}

/// All that it can be told to do.
std::vector<std::string> tasks_of(const bus::ParticipantInfo &participant) {
  std::vector<std::string> tasks{"solve", "prepare", "commit"};
  tasks.insert(tasks.end(), participant.tasks.begin(), participant.tasks.end());
  return tasks;
}

/// "declares no such output".
std::string lack(const std::string &field, const bus::ParticipantInfo &participant, bool output) {
  std::vector<std::string> others;
  for (const auto &f : participant.fields)
    if (f.output == output)
      others.push_back(f.name);
  return participant.name + " declares no such " + (output ? "output" : "input") + hint(field, others);
}

/// "'blood_force' from fluid to mech (mech declares no such input)": what a line needs and somebody does not have, or
/// nothing. A scheme of our own has tasks for all who may take part.
std::string missing_of(const Node &node, const std::vector<bus::ParticipantInfo> &participants) {
  if (!are_there(node, participants))
    return "";
  const bus::ParticipantInfo &who = *find(participants, node.participant);
  const bool is_written = !node.where.empty();
  if (node.kind == Node::Kind::transfer && !may_be_left_out(node, participants) &&
      !is_known_to_both(node, participants)) {
    const bool is_sent = knows(who, node.field, true);
    return "'" + node.field + "' from " + node.participant + " to " + node.receiver + " (" +
           (is_sent ? lack(node.field, *find(participants, node.receiver), false) : lack(node.field, who, true)) + ")";
  }
  if (node.kind == Node::Kind::task && is_written && !is_in(node.task, who.tasks))
    return "'" + node.task + "' of " + who.name + " (no such task" + hint(node.task, tasks_of(who)) + ")";
  if (node.kind == Node::Kind::until && is_written && !is_in(node.field, names_of(who.scalars)))
    return "'" + node.field + "' of " + who.name + " (no such scalar" + hint(node.field, names_of(who.scalars)) + ")";
  return "";
}

void collect_missing(const Nodes &nodes, const std::vector<bus::ParticipantInfo> &participants,
                     std::vector<std::string> &missing) {
  for (const Node &node : nodes) {
    const std::string what = missing_of(node, participants);
    const std::string text = node.where.empty() ? what : node.where + ": " + what;
    if (!what.empty() && !is_in(text, missing))
      missing.push_back(text);
    collect_missing(node.body, participants, missing);
  }
}

/// Without what they are in.
Nodes with_bodies(const Nodes &nodes) {
  Nodes all;
  for (const Node &node : nodes) {
    all.push_back(node);
    const Nodes inner = with_bodies(node.body);
    all.insert(all.end(), inner.begin(), inner.end());
  }
  return all;
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

} // namespace

Sequence drop_absent(const Sequence &sequence, const std::vector<bus::ParticipantInfo> &participants) {
  std::vector<std::string> missing;
  for (const Nodes *nodes : {&sequence.constants, &sequence.start, &sequence.step})
    collect_missing(*nodes, participants, missing);
  if (!missing.empty())
    throw Failure(ExitCode::handshake, "the scheme " + sequence.name + " needs " + config::joined(missing));
  Sequence kept = sequence;
  for (Nodes *nodes : {&kept.start, &kept.step, &kept.constants})
    *nodes = drop_absent(*nodes, participants);
  return kept;
}

void check_names(const Sequence &sequence, const std::vector<std::string> &participants) {
  for (const Nodes *nodes : {&sequence.constants, &sequence.start, &sequence.step})
    for (const Node &node : with_bodies(*nodes))
      for (const std::string &name : {node.participant, node.receiver})
        if (!node.where.empty() && !name.empty() && !is_in(name, participants))
          throw Failure(ExitCode::scene, node.where + ": the scene has no participant '" + name + "'" +
                                             config::did_you_mean(name, participants) + " It has " +
                                             config::joined(participants));
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

} // namespace heartbus::coupler
