#include "common/bus/handshake.h"

#include "common/base/failure.h"
#include "common/mapping/conforming_map.h"
#include "common/mapping/point_hash.h"

#include <algorithm>
#include <set>
#include <sstream>

namespace heartbus::bus {
namespace {

std::string ranks_text(int ranks) { return std::to_string(ranks) + (ranks == 1 ? " rank" : " ranks"); }

std::string list(const std::map<std::string, Coordinator::Expected> &expected) {
  std::ostringstream text;
  for (const auto &[name, who] : expected)
    text << (text.tellp() > 0 ? ", " : "") << name << " (" << (who.program.empty() ? "any program" : who.program)
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

bool same_set(const PointSetInfo &a, const PointSetInfo &b) { return a.name == b.name && a.n_corners == b.n_corners; }

/// Numbers of the points at these places.
std::vector<int> numbers_of(const std::vector<double> &places, const PartnerPoints &set, const std::string &name) {
  std::vector<mapping::Point> points(set.coordinates.size() / 3);
  for (std::size_t i = 0; i < points.size(); ++i)
    std::copy_n(set.coordinates.data() + 3 * i, 3, points[i].begin());
  const double radius = mapping::relative_tolerance * set.spacing;
  const mapping::PointHash hash(points, 2 * radius);
  std::vector<int> numbers;
  for (std::size_t i = 0; i < places.size(); i += 3) {
    const auto found = hash.within({places[i], places[i + 1], places[i + 2]}, radius);
    if (found.empty())
      throw Failure(ExitCode::map, "a face of " + name + " has a corner at (" + std::to_string(places[i]) + ", " +
                                       std::to_string(places[i + 1]) + ", " + std::to_string(places[i + 2]) +
                                       ") m, which is none of its points");
    numbers.push_back(found.front());
  }
  return numbers;
}

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
    else if (!who.program.empty() && world.members()[ranks.front()].program != base_name(who.program))
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

const ParticipantInfo &find_partner(const std::vector<ParticipantInfo> &participants, const std::string &asker,
                                    const Question &question) {
  std::string others;
  for (const ParticipantInfo &participant : participants) {
    if (participant.name == question.participant && participant.name != asker)
      return participant;
    if (participant.name != asker)
      others += (others.empty() ? "" : ", ") + participant.name;
  }
  throw Failure(ExitCode::handshake, asker + " asks for the points '" + question.point_set + "' of '" +
                                         question.participant + "', who does not take part; the others are " + others);
}

PartnerPoints points_for_others(const ParticipantInfo &participant, const std::string &set_name) {
  const PointSetInfo &set = point_set(participant, set_name);
  PartnerPoints points;
  for (const auto &of_rank : set.coordinates)
    points.coordinates.insert(points.coordinates.end(), of_rank.begin(), of_rank.end());
  points.spacing = set.spacing;
  points.n_corners = set.n_corners;
  points.faces = numbers_of(set.faces, points, participant.name + "." + set_name);
  return points;
}

std::string who_asks_whom(const World &world, const std::map<int, Question> &questions) {
  std::set<std::string> lines;
  for (const auto &[rank, question] : questions)
    lines.insert(world.members()[rank].name + " asks for the points '" + question.point_set + "' of " +
                 question.participant + " first");
  std::string text;
  for (const std::string &line : lines)
    text += (text.empty() ? "" : "; ") + line;
  return text;
}

void merge_declaration(ParticipantInfo &participant, int rank, const ParticipantInfo &declared) {
  if (participant.point_sets.empty()) {
    participant.fields = declared.fields;
    participant.tasks = declared.tasks;
    participant.scalars = declared.scalars;
    participant.point_sets = declared.point_sets;
    for (PointSetInfo &set : participant.point_sets) {
      set.coordinates.assign(participant.n_ranks, {});
      set.faces.clear();
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
    set.faces.insert(set.faces.end(), sets[i].faces.begin(), sets[i].faces.end());
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
  if (sent.is_global() != received.is_global())
    throw Failure(ExitCode::handshake, "field '" + field + "' is " + (sent.is_global() ? "global" : "one of points") +
                                           " at " + from.name + ", but " +
                                           (sent.is_global() ? "one of points" : "global") + " at " + to.name);
  return {sent, received};
}

const PointSetInfo &point_set(const ParticipantInfo &participant, const std::string &name) {
  for (const PointSetInfo &set : participant.point_sets)
    if (set.name == name)
      return set;
  std::string names;
  for (const PointSetInfo &set : participant.point_sets)
    names += " " + set.name;
  throw Failure(ExitCode::handshake, participant.name + " declares no point set '" + name + "'; it has:" + names);
}

} // namespace heartbus::bus
