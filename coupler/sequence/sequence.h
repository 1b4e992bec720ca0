#pragma once

#include "common/bus/coordinator.h"

#include <string>
#include <utility>
#include <vector>

namespace heartbus::coupler {

/// One line of a coupling scheme.
struct Node {
  enum class Kind { prepare, solve, commit, task, transfer, repeat };
  Kind kind = Kind::solve;
  std::string participant; ///< who acts, or who sends
  std::string task;        ///< of Kind::task
  std::string receiver;    ///< of Kind::transfer
  std::string field;       ///< of Kind::transfer
  int times = 1;           ///< of Kind::repeat
  std::vector<Node> body;  ///< of Kind::repeat
};
using Nodes = std::vector<Node>;

/// A coupling scheme is data: what happens once before the first step, and what happens in each step.
struct Sequence {
  std::string name;
  Nodes start, step;
};

/// The scheme of this name: EFS1, E1FS (with so many iterations), E1FSinf, electromechanics.
Sequence make_sequence(const std::string &scheme, int iterations);

/// Without the lines whose participants are absent, and without tasks that a participant does not offer.
Sequence cast(const Sequence &sequence, const std::vector<bus::ParticipantInfo> &participants);

/// A node of the sequence with repetitions written out.
struct Action {
  Node node;
  int iteration = 0; ///< of the innermost repetition; keeps its last value after it
};
std::vector<Action> written_out(const Nodes &nodes);

/// As printed at the start of a run.
std::string to_text(const Sequence &sequence);

/// Throws Failure(handshake) unless: everyone solves and commits once, nobody acts after its commit, each
/// input that somebody offers is received before the first solve that reads it, and each field sent has been computed.
void check(const Sequence &sequence, const std::vector<bus::ParticipantInfo> &participants);

} // namespace heartbus::coupler
