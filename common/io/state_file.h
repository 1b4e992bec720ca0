#pragma once

#include "common/io/state.h"

#include <functional>
#include <mpi.h>

namespace heartbus::io {

/// A State in one HDF5 file: a group a point set with its `points` [point][3] [m] and a table [point][component] a
/// field; numbers are attributes of the file. Only rank 0 touches the file. Collective.
void save_state(MPI_Comm communicator, const std::string &file_name, const std::function<void(State &)> &visit);

/// The fields come back through a conforming map, whoever wrote them on however many ranks. Failure(map) when the
/// points differ, Failure(file) when something is missing or of another size.
void load_state(MPI_Comm communicator, const std::string &file_name, const std::function<void(State &)> &visit);

} // namespace heartbus::io
