#pragma once

#include "common/linear_algebra/nodal_matrix.h"

namespace heartbus::fem {

/// A matrix in single precision, for the iterations that solve for a correction: solvers are bound by what they read,
/// and the rounding (6e-8 of an entry) is far below their tolerances, since the residual that is corrected is of the
/// exact matrix. It is rounded from a matrix in double precision, or assembled in single precision with the pattern and
/// constraints of one.
class RoundedMatrix {
 public:
  /// Rounds `matrix`, whose values may change afterwards; all but `vmult` need it to live on.
  explicit RoundedMatrix(const NodalMatrix &matrix);

  unsigned components() const { return components_; }
  const NodalMatrix &pattern() const { return pattern_; }
  const float *values() const { return values_.data(); } ///< block after block, in the order of `pattern`

  void clear();
  void add_batch(unsigned batch, Lanes *K); ///< as of NodalMatrix; of four components
  /// Adds a value to the first n diagonals of the block between nodes a and b (cell node indices) of a slot.
  void add_to_diagonals(unsigned slot, unsigned a, unsigned b, unsigned n, double value);
  void copy_to(NodalMatrix &matrix) const;      ///< of the same space, for those who need another form
  void vmult(Vector &y, const Vector &x) const; ///< y = A x

 private:
  const NodalMatrix &pattern_;
  unsigned components_;
  int n_nodes_;
  std::vector<int> begin_, columns_; ///< of the blocks of each owned node; local nodes
  std::vector<float> values_;        ///< block after block, each column by column, and one number more
  mutable std::vector<double> fours_;
};

} // namespace heartbus::fem
