#include "common/bus/handshake.h"

#include "common/bus/failure.h"

#include <algorithm>
#include <sstream>

namespace heartbus::bus {
namespace {

std::string ranks_text(int ranks) { return std::to_string(ranks) + (ranks == 1 ? " rank" : " ranks"); }

std::string list(const std::map<std::string, Coordinator::Expected> &expected) {
  std::ostringstream text;
  for (const auto &[name, who] : expected)
    text << (text.tellp() > 0 ? ", " : "") << name << " (" << who.program
         << (who.ranks > 0 ? ", " + ranks_text(who.ranks) : "") << ")";
  return text.str();
}

/// Scenes may name a program by its path.
std::string base_name(const std::string &path) { return path.substr(path.rfind('/') + 1); }

const FieldInfo *find_field(const ParticipantInfo &participant, const std::string &name, bool output) {
  for (const FieldInfo &field : participant.fields)
    if (field.name == name && field.output == output)
      return &field;
  return nullptr;
}

const FieldInfo &require_field(const ParticipantInfo &participant, const std::string &name, bool output) {
  if (const FieldInfo *field = find_field(participant, name, output))
    return *field;
  std::string message = participant.name + " declares no " + (output ? "output" : "input") + " '" + name + "'; it has:";
  for (const FieldInfo &field : participant.fields)
    if (field.output == output)
      message += " " + field.name;
  throw Failure(ExitCode::handshake, message);
}

bool same_field(const FieldInfo &a, const FieldInfo &b) {
  return a.name == b.name && a.point_set == b.point_set && a.unit == b.unit && a.components == b.components &&
         a.output == b.output;
}

bool same_set(const PointSetInfo &a, const PointSetInfo &b) { return a.name == b.name; }

} // namespace

const FieldInfo *ParticipantInfo::field(const std::string &field_name) const {
  for (const FieldInfo &field : fields)
    if (field.name == field_name)
      return &field;
  return nullptr;
}

void compare_members(const World &world, const std::map<std::string, Coordinator::Expected> &expected) {
  std::string problem;
  for (const auto &[name, who] : expected) {
    const auto ranks = world.ranks_of(name);
    if (ranks.empty())
      problem = "participant '" + name + "' is missing";
    else if (world.members()[ranks.front()].program != base_name(who.program))
      problem = "participant '" + name + "' is played by the wrong program";
    else if (who.ranks > 0 && static_cast<int>(ranks.size()) != who.ranks)
      problem = "participant '" + name + "' has " + ranks_text(ranks.size());
    if (!problem.empty())
      break;
  }
  for (const Member &member : world.members())
    if (problem.empty() && !member.coupler && expected.count(member.name) == 0)
      problem = "participant '" + member.name + "' is not in the scene";
  if (!problem.empty())
    throw Failure(ExitCode::handshake, problem + "\n  expected: " + list(expected) + "\n  came: " + world.who_came());
}

void merge_declaration(ParticipantInfo &participant, int rank, const ParticipantInfo &declared) {
  if (participant.point_sets.empty()) {
    participant.fields = declared.fields;
    participant.tasks = declared.tasks;
    participant.scalars = declared.scalars;
    participant.point_sets = declared.point_sets;
    for (PointSetInfo &set : participant.point_sets) {
      set.coordinates.assign(participant.n_ranks, {});
      set.spacing = 0;
    }
  }
  const auto &sets = declared.point_sets;
  if (!std::equal(sets.begin(), sets.end(), participant.point_sets.begin(), participant.point_sets.end(), same_set) ||
      !std::equal(declared.fields.begin(), declared.fields.end(), participant.fields.begin(), participant.fields.end(),
                  same_field) ||
      declared.tasks != participant.tasks || declared.scalars.size() != participant.scalars.size())
    throw Failure(ExitCode::handshake, "the ranks of " + participant.name + " declare different fields or tasks");
  for (std::size_t i = 0; i < sets.size(); ++i) {
    PointSetInfo &set = participant.point_sets[i];
    set.coordinates[rank] = sets[i].coordinates.front();
    if (!set.coordinates[rank].empty())
      set.spacing = set.spacing > 0 ? std::min(set.spacing, sets[i].spacing) : sets[i].spacing;
  }
}

std::pair<FieldInfo, FieldInfo> agree_on_field(const ParticipantInfo &from, const ParticipantInfo &to,
                                               const std::string &field) {
  const FieldInfo &sent = require_field(from, field, true), &received = require_field(to, field, false);
  if (sent.unit != received.unit)
    throw Failure(ExitCode::handshake, "field '" + field + "' is sent by " + from.name + " in '" + sent.unit +
                                           "', but expected by " + to.name + " in '" + received.unit + "'");
  if (sent.components != received.components)
    throw Failure(ExitCode::handshake, "field '" + field + "' has " + std::to_string(sent.components) +
                                           " components at " + from.name + ", but " +
                                           std::to_string(received.components) + " at " + to.name);
  return {sent, received};
}

const PointSetInfo &point_set(const ParticipantInfo &participant, const std::string &name) {
  for (const PointSetInfo &set : participant.point_sets)
    if (set.name == name)
      return set;
  throw Failure(ExitCode::handshake, participant.name + " declares no point set '" + name + "'");
}

} // namespace heartbus::bus
