#pragma once

#include "common/fem/constraints.h"
#include "common/linear_algebra/block_pattern.h"
#include "common/linear_algebra/block_product_kernel.h"

#include <algorithm>
#include <memory>
#include <vector>

namespace heartbus::fem {

/// Square sparse matrix of dense blocks between the nodes of a space, of `components` (1, 3 or 4) rows and columns.
/// Numbers are double, or float for iterations that solve for a correction: solvers are bound by what they read, and
/// the rounding (6e-8 of an entry) is far below their tolerances, since the residual that is corrected is of the
/// exact matrix.
///
/// Only rows of owned nodes are kept. They lie block after block in the order of the pattern, each block column by
/// column.
///
/// Constrained degrees of freedom (set_constraints): their rows and columns keep only the diagonal. Systems are
/// solved for increments, whose constrained entries are zero, so no right-hand side needs lifting: zero those entries
/// of the right-hand side with `zero_constrained`.
template <class Number>
class BlockMatrix {
 public:
  using Pattern = std::shared_ptr<const BlockPattern>;
  BlockMatrix(const LagrangeSpace &space, unsigned components)
      : BlockMatrix(std::make_shared<const BlockPattern>(space), components) {}
  /// All matrices of a space can share its pattern.
  BlockMatrix(Pattern pattern, unsigned components);
  /// The same values in other numbers, without constraints.
  template <class Other>
  explicit BlockMatrix(const BlockMatrix<Other> &other) : BlockMatrix(other.pattern(), other.components()) {
    copy(other);
  }

  unsigned components() const { return components_; }
  const LagrangeSpace &space() const { return pattern_->space(); }
  const Pattern &pattern() const { return pattern_; }
  std::size_t n_rows() const { return std::size_t(components_) * pattern_->n_rows(); }
  std::size_t n_entries() const { return values_.size() - 1; }
  Number *values() { return values_.data(); }
  const Number *values() const { return values_.data(); } ///< and one number more

  /// One flag for each local degree of freedom (node*components + c), ghosts included; empty means none.
  void set_constraints(const Constraints &constrained);

  /// Sets all values to zero.
  void clear() { std::fill(values_.begin(), values_.end(), Number(0)); }
  /// Adds the cell matrices of one batch: K[((a*n + b)*components + i)*components + j] couples row (a, i) to column
  /// (b, j), n = nodes_per_cell. Unused slots are skipped. Of K, rows and columns of constraints are first reduced to
  /// the diagonal.
  void add_batch(unsigned batch, VectorizedDouble *K);
  /// Adds one block [i][j] between nodes a and b (cell node indices) of a slot.
  void add_block(unsigned slot, unsigned a, unsigned b, const double *block);
  /// The same between two local nodes, the first of them owned; blocks outside the pattern are left out.
  void add_block(unsigned node, unsigned column_node, const double *block);
  /// Adds a value to the first n diagonal entries of the block between nodes a and b (cell node indices) of a slot.
  void add_to_diagonals(unsigned slot, unsigned a, unsigned b, unsigned n, double value);
  /// Adds to the diagonal entry of a local degree of freedom (ignored when not owned).
  void add_diagonal(unsigned local_dof, double value);
  /// Reduces rows and columns of these local degrees of freedom to the diagonal, after assembly.
  void decouple(const Constraints &dofs);
  /// *this = other, *this = a * other, *this += a * other, for matrices of one space and number of components, whose
  /// constraints do not matter.
  template <class Other>
  void copy(const BlockMatrix<Other> &other) {
    std::transform(other.values(), other.values() + values_.size(), values_.begin(), [](Other x) { return Number(x); });
  }
  void copy_scaled(double a, const BlockMatrix &other);
  void add_scaled(double a, const BlockMatrix &other);

  /// y = A x. Ghosts of x need not be up to date.
  void vmult(Vector &y, const Vector &x) const;
  /// The same for each of three components of x, by a matrix of one component.
  void vmult_3rhs(Vector &y, const Vector &x) const;
  /// The entry (row, column) of owned row and local column dof; 0 when outside the pattern.
  double entry(unsigned local_row, unsigned local_column) const;
  /// Diagonal values of the owned rows.
  void diagonal(Vector &d) const;

 private:
  std::size_t place(int block, unsigned i, unsigned j) const {
    return (std::size_t(block) * components_ + j) * components_ + i;
  }
  bool couples(unsigned row, unsigned column) const { ///< whether constraints leave the entry of these local dofs
    return constrained_.empty() || row == column || !(constrained_[row] || constrained_[column]);
  }
  BlockRows<Number> rows() const;
  void constrain(unsigned batch, VectorizedDouble *K) const;
  void add_to(int block, unsigned row_node, unsigned column_node, const double *values);
  const double *padded(const Vector &x) const;

  Pattern pattern_;
  unsigned components_;
  std::vector<Number> values_; ///< and one more, which is loaded with the last block
  Constraints constrained_;    ///< empty: none
  std::vector<std::uint8_t> slot_constrained_;
  mutable std::vector<double> padded_; ///< x in fours
};

} // namespace heartbus::fem
