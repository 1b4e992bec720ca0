#pragma once

#include "common/bus/coordinator.h"
#include "common/bus/protocol.h"
#include "common/bus/world.h"

#include <map>
#include <string>

namespace heartbus::bus {

/// Who came against who is expected by the scene; Failure(handshake) lists both.
void compare_members(const World &world, const std::map<std::string, Coordinator::Expected> &expected);

/// Adds one rank's declaration to its participant's; Failure(handshake) when its ranks declare different things.
void merge_declaration(ParticipantInfo &participant, int rank, const ParticipantInfo &declared);

/// Of whose points `asker` wants to know; Failure(handshake) when there is no such participant.
const ParticipantInfo &find_partner(const std::vector<ParticipantInfo> &participants, const std::string &asker,
                                    const Question &question);
/// A point set that has been declared, with its faces in numbers of its points. Failure(handshake) when there is none;
/// Failure(map) when a face has a corner that is none of the points.
PartnerPoints points_for_others(const ParticipantInfo &participant, const std::string &point_set);
/// "ep asks for points of mech; mech asks for points of ep"
std::string who_asks_whom(const World &world, const std::map<int, Question> &questions);

/// The field as `from` declares it for sending and as `to` declares it for receiving; Failure(handshake) when one is
/// missing or unit or components differ.
std::pair<FieldInfo, FieldInfo> agree_on_field(const ParticipantInfo &from, const ParticipantInfo &to,
                                               const std::string &field);
const PointSetInfo &point_set(const ParticipantInfo &participant, const std::string &name);

} // namespace heartbus::bus
