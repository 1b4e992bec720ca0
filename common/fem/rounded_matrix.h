#pragma once

#include "common/fem/nodal_matrix.h"

namespace heartbus::fem {

/// A matrix in single precision, for the iterations that solve for a correction: solvers are bound by what they read, and the
/// rounding (6e-8 of an entry) is far below their tolerances, since the residual that is corrected is of the exact matrix.
class RoundedMatrix {
 public:
  explicit RoundedMatrix(const NodalMatrix &matrix); ///< the matrix may change afterwards
  void vmult(Vector &y, const Vector &x) const;      ///< y = A x

 private:
  unsigned components_;
  int n_nodes_;
  std::vector<int> begin_, columns_; ///< of the blocks of each owned node; local nodes
  std::vector<float> values_;        ///< block after block, each column by column, and one number more
  mutable std::vector<double> fours_;
};

} // namespace heartbus::fem
