#pragma once

#include "common/linear_algebra/linear_solver.h"

namespace heartbus::fem {

/// The factors of a matrix (MUMPS): an inverse up to round-off, for systems that no preconditioner is good for. Memory
/// and time grow faster than the mesh. Throws Failure(not_converged) where they cannot be made, of a singular matrix or
/// with too little memory. Collective.
std::unique_ptr<Preconditioner> make_direct_solver(const BlockMatrix<double> &matrix);

} // namespace heartbus::fem
