#pragma once

#include "common/base/failure.h"
#include "common/geometry/mesh.h"

#include <functional>
#include <mpi.h>

namespace heartbus::fem {

/// Collective: the first rank acts; what it finds wrong ends all of them with the same Failure.
void on_root(MPI_Comm communicator, const std::function<void()> &action);

/// Collective: the first rank makes or reads a mesh and holds it; the others know its kind, labels and regions alone.
geometry::Mesh mesh_on_root(MPI_Comm communicator, const std::function<geometry::Mesh()> &make);

} // namespace heartbus::fem
