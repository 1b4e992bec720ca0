#pragma once

#include "common/linear_algebra/block_matrix.h"

#include <Epetra_CrsMatrix.h>

#include <memory>

namespace heartbus::fem {

/// The matrix as Trilinos stores one, for its preconditioners. Rows and columns have the numbers of the degrees of
/// freedom, global node * components + component. Collective.
std::unique_ptr<Epetra_CrsMatrix> trilinos_copy(const BlockMatrix<double> &matrix);

/// Brings the values of a copy up to date.
void copy_values(const BlockMatrix<double> &matrix, Epetra_CrsMatrix &copy);

} // namespace heartbus::fem
