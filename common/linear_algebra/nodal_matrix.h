#pragma once

#include "common/fem/lagrange_space.h"
#include "common/linear_algebra/factor_pattern.h"

#include <deal.II/lac/trilinos_sparse_matrix.h>

namespace heartbus::fem {

/// Square sparse matrix of dense b x b blocks between the nodes of a space. Cell matrices go straight into Trilinos'
/// value array through positions computed once; only rows of owned nodes are kept, and they are complete because each
/// rank also visits the ghost cells that touch its nodes.
///
/// Constrained degrees of freedom (set_constraints): their rows and columns keep only the diagonal. Systems are solved
/// for increments, whose constrained entries are zero, so no right-hand side needs lifting: zero those entries of the
/// right-hand side with `zero_constrained`.
class NodalMatrix {
 public:
  NodalMatrix(const LagrangeSpace &space, unsigned components);

  unsigned components() const { return components_; }
  const LagrangeSpace &space() const { return space_; }

  /// One flag for each local degree of freedom (node*components + c), ghosts included; empty means none.
  void set_constraints(const std::vector<std::uint8_t> &constrained);

  /// Sets all values to zero.
  void clear();
  /// Adds the cell matrices of one batch: K[((a*n + b)*components + i)*components + j] couples row (a, i) to column
  /// (b, j), n = nodes_per_cell. Unused slots are skipped. Of K, rows and columns of constraints are first reduced to the
  /// diagonal.
  void add_batch(unsigned batch, Lanes *K);
  /// Adds one block [i][j] between nodes a and b (cell node indices) of a slot.
  void add_block(unsigned slot, unsigned a, unsigned b, const double *block);
  /// The same between two local nodes, the first of them owned; blocks outside the pattern are left out.
  void add_block(unsigned node, unsigned column_node, const double *block);
  /// Reduces rows and columns of these degrees of freedom to the diagonal, after assembly.
  void decouple(const std::vector<std::uint8_t> &dofs);
  /// Adds to the diagonal entry of a local degree of freedom (ignored when not owned).
  void add_diagonal(unsigned local_dof, double value);

  /// y = A x. Ghosts of x need not be up to date.
  void vmult(Vector &y, const Vector &x) const;
  /// The same for each of three components of x, by a matrix of one component.
  void vmult_threefold(Vector &y, const Vector &x) const;
  const dealii::TrilinosWrappers::SparseMatrix &trilinos() const { return matrix_; }
  /// The entry (row, column) of owned row and local column dof; 0 when outside the pattern.
  double entry(unsigned local_row, unsigned local_column) const;
  /// Diagonal values of the owned rows.
  void diagonal(Vector &d) const;
  /// *this = a * other (same space and components, constraints not applied again).
  void copy_scaled(double a, const NodalMatrix &other);
  /// *this += a * other.
  void add_scaled(double a, const NodalMatrix &other);

  // For those who keep values of the same pattern elsewhere.
  /// Reduces the rows and columns of constraints in the cell matrices of a batch to the diagonal.
  void constrain(unsigned batch, Lanes *K) const;
  /// Calls visit(lane, node, positions) for each lane of the batch whose cell node a is owned here. The block of cell
  /// node b starts positions[b] entries after the begin of the node's first row.
  template <class Visit>
  void visit_rows(unsigned batch, unsigned a, const Visit &visit) const;
  /// Offset of the block (a, b) of a slot within the first row of its node a; -1: not owned.
  int position(unsigned slot, unsigned a, unsigned b) const {
    return positions_[(std::size_t(slot) * space_.nodes_per_cell() + a) * space_.nodes_per_cell() + b];
  }
  /// Whether constraints leave the entry of these local degrees of freedom.
  bool couples(unsigned row, unsigned column) const {
    return constrained_.empty() || row == column || !(constrained_[row] || constrained_[column]);
  }

  /// Of its incomplete factorisations; made when asked for the first time, which is collective.
  std::shared_ptr<const FactorPattern> factor_pattern() const;

  // Raw rows for those who extract sub-matrices: Trilinos' arrays of this rank.
  int n_rows() const { return n_rows_; }
  const int *row_begin() const { return row_begin_; }
  const int *columns() const { return columns_; } ///< Trilinos' local column numbers
  /// The local node of the column of each block, in the order of the first rows of the nodes.
  const int *column_nodes() const { return block_columns_.data(); }
  double *values() { return values_; }
  const double *values() const { return values_; }

 private:
  int column_of(unsigned local_dof) const;    ///< Trilinos' local number
  int position_of(int row, int column) const; ///< in the value array; -1: outside the pattern
  void collect_blocks();
  const LagrangeSpace &space_;
  unsigned components_;
  dealii::TrilinosWrappers::SparseMatrix matrix_;
  int n_rows_ = 0;
  int *row_begin_ = nullptr, *columns_ = nullptr;
  double *values_ = nullptr;
  std::vector<int> block_begin_, block_columns_; ///< blocks of each owned node, by the local node of their column
  std::vector<int> positions_;            ///< [slot][a][b] offset of the block within the first row of a; -1: not owned
  std::vector<std::uint8_t> constrained_; ///< [local dof], empty: none
  std::vector<std::uint8_t> slot_constrained_;
  mutable std::vector<double> fours_; ///< x, padded
  mutable std::shared_ptr<const FactorPattern> factor_pattern_;
};

template <class Visit>
void NodalMatrix::visit_rows(unsigned batch, unsigned a, const Visit &visit) const {
  for (unsigned lane = 0; lane < n_lanes; ++lane) {
    const unsigned slot = batch * n_lanes + lane;
    if (space_.slot_used(slot) && position(slot, a, 0) >= 0)
      visit(lane, space_.cell_nodes(slot)[a],
            &positions_[(std::size_t(slot) * space_.nodes_per_cell() + a) * space_.nodes_per_cell()]);
  }
}

/// Zeroes the constrained owned entries of a vector.
void zero_constrained(Vector &v, const std::vector<std::uint8_t> &constrained);

} // namespace heartbus::fem
