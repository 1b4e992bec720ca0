#pragma once

#include <mpi.h>

namespace heartbus::bus {

/// Where the ranks of a participant fill the cores of their node, each keeps to one core: participants take turns then,
/// and ranks that are free to move come to lie on one core while the other is idle, now with this participant, now with
/// that. Elsewhere (fewer ranks than cores, cores chosen by the launcher, no Linux) nothing changes. Collective over
/// the participant's ranks; returns the core, or -1.
int keep_to_own_core(MPI_Comm participant);

} // namespace heartbus::bus
