#pragma once

#include "coupler/sequence/sequence.h"

namespace heartbus::coupler {

// Sequences as text, for runs to print and scenes to say:
//
//     solve P    prepare P    commit P    TASK P
//     FIELD P->Q                                         a transfer; with "if known" left out if P or Q does not
//                                                        know the field, with "if wanted" if Q does not
//     3 times                                            and lines of its own
//     at most 9 times until SCALAR of P < LIMIT          the same; with "or fail" the limit must be reached

/// A scheme as a scene says it, under `coupling.sequence`.
std::string to_yaml(const Sequence &sequence);

/// Nodes one below the other as entries of a list, each after a line break.
std::string to_lines(const Nodes &nodes, const std::string &indent = "  ");

/// All that is done in a run, a block in each line.
std::string to_text(const Sequence &sequence);

/// The inverse of to_yaml. Failure(scene) naming the line and what it could be.
Sequence parse(const WrittenScheme &written);

} // namespace heartbus::coupler
