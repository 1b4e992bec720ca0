#include "common/fem/block_ilu.h"

#include "common/bus/failure.h"

#include <Epetra_CrsMatrix.h>
#include <Epetra_Import.h>
#include <Epetra_Map.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace heartbus::fem {
namespace {

template <unsigned b>
using Block = std::array<double, b * b>; ///< row by row

/// c -= a d
template <unsigned b>
void subtract_product(Block<b> &c, const Block<b> &a, const Block<b> &d) {
  for (unsigned i = 0; i < b; ++i)
    for (unsigned k = 0; k < b; ++k)
      for (unsigned j = 0; j < b; ++j)
        c[b * i + j] -= a[b * i + k] * d[b * k + j];
}

/// Gauss-Jordan; the pivots come in the order of the components, each of which is positive in a stabilised problem.
template <unsigned b>
Block<b> inverse(Block<b> a) {
  for (unsigned k = 0; k < b; ++k) {
    const double pivot = 1 / a[(b + 1) * k];
    if (!std::isfinite(pivot))
      throw Failure(ExitCode::not_converged, "the incomplete factorisation met a zero pivot");
    a[(b + 1) * k] = 1;
    for (unsigned j = 0; j < b; ++j)
      a[b * k + j] *= pivot;
    for (unsigned i = 0; i < b; ++i)
      if (i != k) {
        const double factor = a[b * i + k];
        a[b * i + k] = 0;
        for (unsigned j = 0; j < b; ++j)
          a[b * i + j] -= factor * a[b * k + j];
      }
  }
  return a;
}

/// The blocks between local nodes, row after row: those of the owned nodes, then those of the ghosts.
template <unsigned b>
class LocalRows {
 public:
  explicit LocalRows(const NodalMatrix &matrix) : matrix_(matrix), local_numbers_(*matrix.space().partitioner(1)) {
    begin.reserve(matrix.space().n_local_nodes() + 1);
    begin.push_back(0);
    add_owned_rows();
    add_ghost_rows();
  }

  std::vector<int> begin, columns; ///< columns of a row: local nodes, sorted
  std::vector<Block<b>> blocks;

 private:
  void add_owned_rows() {
    const int *row_begin = matrix_.row_begin(), *column_nodes = matrix_.column_nodes();
    for (int row = 0; row < matrix_.n_rows(); row += b) {
      for (int k = row_begin[row]; k < row_begin[row + 1]; k += b) {
        Block<b> &block = row_.emplace_back(*column_nodes++, Block<b>()).second;
        for (unsigned i = 0; i < b; ++i)
          std::copy_n(matrix_.values() + row_begin[row + i] + (k - row_begin[row]), b, &block[b * i]);
      }
      finish_row();
    }
  }

  /// They come from their owners; of their blocks, those count whose column is here, too.
  void add_ghost_rows() {
    const LagrangeSpace &space = matrix_.space();
    const Epetra_CrsMatrix &owned = matrix_.trilinos().trilinos_matrix();
    std::vector<int> dofs;
    for (unsigned node = space.n_owned_nodes(); node < space.n_local_nodes(); ++node)
      for (unsigned i = 0; i < b; ++i)
        dofs.push_back(int(space.global_node(node) * b + i));
    const Epetra_Map ghosts(-1, int(dofs.size()), dofs.data(), 0, owned.Comm());
    Epetra_CrsMatrix rows(Copy, ghosts, 0);
    rows.Import(owned, Epetra_Import(ghosts, owned.RowMap()), Insert);
    for (const int dof : dofs) {
      int n, *dofs_of_row;
      double *values;
      rows.ExtractGlobalRowView(dof, n, values, dofs_of_row);
      for (int k = 0; k < n; ++k)
        if (const unsigned node = unsigned(dofs_of_row[k]) / b;
            local_numbers_.in_local_range(node) || local_numbers_.is_ghost_entry(node))
          block_of(int(local_numbers_.global_to_local(node)))[b * (dof % b) + dofs_of_row[k] % b] = values[k];
      if (dof % b == b - 1)
        finish_row();
    }
  }

  Block<b> &block_of(int column) {
    for (auto &[other, block] : row_)
      if (other == column)
        return block;
    return row_.emplace_back(column, Block<b>()).second;
  }

  void finish_row() {
    std::sort(row_.begin(), row_.end(), [](const auto &x, const auto &y) { return x.first < y.first; });
    for (const auto &[column, block] : row_) {
      columns.push_back(column);
      blocks.push_back(block);
    }
    begin.push_back(int(columns.size()));
    row_.clear();
  }

  const NodalMatrix &matrix_;
  const dealii::Utilities::MPI::Partitioner &local_numbers_;
  std::vector<std::pair<int, Block<b>>> row_; ///< that is being gathered: columns and their blocks
};

/// In place: L below the diagonal, U above it, the inverse of U's blocks on it. Returns where those are.
template <unsigned b>
std::vector<int> decompose(LocalRows<b> &rows) {
  const std::vector<int> &begin = rows.begin, &columns = rows.columns;
  auto &blocks = rows.blocks;
  const int n = int(begin.size()) - 1;
  std::vector<int> diagonal, position(n, -1); // of the blocks of the current row
  for (int i = 0; i < n; ++i) {
    for (int k = begin[i]; k < begin[i + 1]; ++k)
      position[columns[k]] = k;
    diagonal.push_back(position[i]);
    for (int k = begin[i]; k < diagonal[i]; ++k) {
      const int pivot_row = columns[k];
      Block<b> L{};
      subtract_product<b>(L, blocks[k], blocks[diagonal[pivot_row]]);
      for (double &value : L)
        value = -value;
      blocks[k] = L;
      for (int j = diagonal[pivot_row] + 1; j < begin[pivot_row + 1]; ++j)
        if (const int target = position[columns[j]]; target >= 0)
          subtract_product<b>(blocks[target], L, blocks[j]);
    }
    blocks[diagonal[i]] = inverse<b>(blocks[diagonal[i]]);
    for (int k = begin[i]; k < begin[i + 1]; ++k)
      position[columns[k]] = -1;
  }
  return diagonal;
}

} // namespace

BlockILU::BlockILU(const NodalMatrix &matrix)
    : components_(matrix.components()), n_owned_(matrix.n_rows() / int(components_)) {
  if (components_ == 1)
    factorise<1>(matrix);
  else if (components_ == 3)
    factorise<3>(matrix);
  else
    factorise<4>(matrix);
}

template <unsigned b>
void BlockILU::factorise(const NodalMatrix &matrix) {
  LocalRows<b> rows(matrix);
  const std::vector<int> diagonal = decompose(rows);
  const int n = int(diagonal.size());
  factors_.reserve(b * b * rows.blocks.size() + 1);
  const auto append = [&](int first, int last) {
    for (int k = first; k < last; ++k) {
      columns_.push_back(rows.columns[k]);
      for (unsigned j = 0; j < b; ++j)
        for (unsigned i = 0; i < b; ++i)
          factors_.push_back(float(rows.blocks[k][b * i + j]));
    }
  };
  for (int i = 0; i < n; ++i) {
    append(rows.begin[i], diagonal[i]);
    end_.push_back(int(columns_.size()));
  }
  for (int i = n - 1; i >= 0; --i) {
    append(diagonal[i] + 1, rows.begin[i + 1]);
    append(diagonal[i], diagonal[i] + 1);
    end_.push_back(int(columns_.size()));
  }
  factors_.push_back(0);
  work_.resize(work_length(b) * std::size_t(n));
}

void BlockILU::vmult(Vector &y, const Vector &x) const {
  const GhostValues ghosts(x);
  solve_block_ilu(factors(), n_owned_, x.begin(), y.begin(), work_.data());
}

void BlockILU::vmult_threefold(Vector &y, const Vector &x) const {
  const GhostValues ghosts(x);
  work_.resize(4 * end_.size() / 2);
  solve_ilu_threefold(factors(), n_owned_, x.begin(), y.begin(), work_.data());
}

BlockFactors BlockILU::factors() const {
  return {components_, int(end_.size() / 2), end_.data(), columns_.data(), factors_.data()};
}

} // namespace heartbus::fem
