#pragma once

#include <mpi.h>

namespace heartbus::fem {

/// Makes deal.II usable on a participant's own communicator in a launch where other programs do not use deal.II.
/// deal.II's own MPI_InitFinalize calls collectives over the whole world and would hang there. MPI must be initialised.
/// Destroy every deal.II object before this one; destroy this one before the communicator is freed.
class Runtime {
 public:
  explicit Runtime(MPI_Comm communicator);
  ~Runtime();
  Runtime(const Runtime &) = delete;
  Runtime &operator=(const Runtime &) = delete;
};

} // namespace heartbus::fem
