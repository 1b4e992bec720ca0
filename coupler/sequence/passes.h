#pragma once

#include "coupler/sequence/sequence.h"

namespace heartbus::coupler {

// From a step as its scheme says it to the order in which it is done. None changes a result but `accelerated`, and
// `with_limit_of_alpha` where alpha follows the limit: tests/unit/passes.cpp.

/// Iterations of a step take the Robin datum from those before by Anderson's method.
Nodes accelerated(const Nodes &step);

/// Lifting and the fluid's assembly first, where the geometry is that of d^n: they need neither calcium nor tension. On
/// cores of their own they are done beside electrophysiology; on shared ones lifting begins while the fluid still
/// commits the step before.
Nodes lifted_early(const Nodes &step);

/// With estimates of the limit of alpha, once the fluid's mesh has been moved: now and then the wall probes with one
/// force after the other how it moves itself and how the blood yields (common/interface/nodal/alpha_limit.h).
/// `dt`: size of a step [s].
Nodes with_limit_of_alpha(const Nodes &step, bool is_followed, double dt);

/// The start block with the first of these estimates, so that the first step does not take as long as ten.
Nodes with_first_limit(const Nodes &start, const Nodes &step);

/// Two solvers at a time are slower on shared cores than one after the other. So electrophysiology, who waits for
/// nobody, goes on when the fluid has been prepared, if that is done first, else when the step before is done.
Nodes in_turns(const Nodes &step);

/// On cores of their own those who receive nothing are told of so many steps in advance.
Sequence ordered_ahead(Sequence sequence, int steps);

} // namespace heartbus::coupler
