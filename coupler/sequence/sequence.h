#pragma once

#include "common/bus/coordinator.h"
#include "common/interface/settings.h"
#include "scene/scene.h"

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace heartbus::coupler {

/// One line of a coupling scheme.
struct Node {
  /// until: the body is repeated until a scalar of a participant is below a limit. The coupler waits for it, hence this
  /// may not stand within a repetition. every: the body is done in one of so many steps, and while a scalar of a
  /// participant is not known (zero). turn: `receiver` goes on, in this step or into the next one, when `participant`
  /// has come so far.
  enum class Kind { prepare, solve, commit, task, transfer, repeat, until, every, turn };
  Kind kind = Kind::solve;
  std::string participant; ///< who acts, or who sends, or whose scalar it is
  std::string task;        ///< of Kind::task
  std::string receiver;    ///< of Kind::transfer and Kind::turn
  std::string field;       ///< of Kind::transfer; of Kind::until and Kind::every the scalar
  int times = 1; ///< of Kind::repeat, at most of Kind::until; of Kind::every and Kind::turn the number of steps
  std::vector<Node> body; ///< of Kind::repeat, Kind::until and Kind::every
  double limit = 0;       ///< of Kind::until
  bool required = false;  ///< of Kind::until: the run fails when the limit is not reached
  bool optional = false;  ///< of Kind::transfer: left out when the one does not offer it or the other does not want it;
                          ///< without others a scheme makes no sense
  bool if_wanted = false; ///< of Kind::transfer: left out when the one does not want it; the other has to offer it then
  std::string where{};    ///< "file:line" of a line that the scene has
};
using Nodes = std::vector<Node>;

/// A coupling scheme is data: what happens once before the first step, and what happens in each step.
struct Sequence {
  std::string name;
  Nodes start, step;
  Nodes constants{}; ///< what never changes: sent before the start block, or before the states are loaded
  std::set<std::string> source_participants{}; ///< who may run ahead of the others,
  int ahead = 0;                               ///< by so many steps
};

/// The scheme that the scene asks for, line by line as it is defined.
Sequence scheme(const CouplingParameters &coupling);

/// The same as it is done in a run: after the passes of passes.h.
Sequence make_sequence(const CouplingParameters &coupling, double dt);

/// What blood and wall are told of the interface, by participant.
std::map<std::string, interface::Texts> interface_settings(const SceneParameters &scene);

/// Failure(scene) when a line of the scene names somebody who is not among these participants.
void check_names(const Sequence &sequence, const std::vector<std::string> &participants);

/// Without the lines whose participants are absent, tasks that a participant does not offer, and transfers that may be
/// left out and are not known to both; of Kind::every all or nothing. Failure(handshake) lists the other transfers
/// that one of the two does not know, and of lines that the scene has also the tasks and scalars.
Sequence drop_absent(const Sequence &sequence, const std::vector<bus::ParticipantInfo> &participants);

/// A node of the sequence with repetitions written out, those without a fixed number once.
struct Action {
  Node node;
  int iteration = 0; ///< of the innermost repetition; keeps its last value after it, but for Kind::every
};
std::vector<Action> flatten(const Nodes &nodes, int first_iteration = 0);

/// Those of a step who receive nothing and on whom no decision depends: they may run ahead of the others.
std::set<std::string> source_participants(const Nodes &step);

/// Throws Failure(handshake) unless: everyone solves and commits once, nobody acts after its commit, each
/// input that somebody offers is received before the first solve or task that reads it, and each field sent has been
/// computed.
void check(const Sequence &sequence, const std::vector<bus::ParticipantInfo> &participants);

} // namespace heartbus::coupler
