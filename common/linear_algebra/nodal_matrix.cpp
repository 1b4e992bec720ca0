#include "common/linear_algebra/nodal_matrix.h"

#include "common/base/failure.h"
#include "common/linear_algebra/block_product_kernel.h"
#include "common/linear_algebra/insertion_kernel.h"

#include <deal.II/lac/trilinos_sparsity_pattern.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_FECrsGraph.h>

#include <set>

namespace heartbus::fem {

NodalMatrix::NodalMatrix(const LagrangeSpace &space, unsigned components) : space_(space), components_(components) {
  const unsigned n = space.nodes_per_cell(), c = components;
  std::vector<std::set<unsigned>> neighbours(space.n_owned_nodes());
  for (unsigned slot = 0; slot < space.n_slots(); ++slot)
    for (unsigned a = 0; a < n; ++a)
      if (const unsigned node = space.cell_nodes(slot)[a]; node < space.n_owned_nodes())
        neighbours[node].insert(space.cell_nodes(slot), space.cell_nodes(slot) + n);

  const dealii::IndexSet &owned = space.partitioner(c)->locally_owned_range();
  std::size_t longest = 0;
  for (const auto &row : neighbours)
    longest = std::max(longest, row.size());
  dealii::TrilinosWrappers::SparsityPattern pattern(owned, owned, space.communicator(), longest * c);
  // Else Epetra leaves the ghost columns of an owner in any order, from the second owner on, and blocks fall to pieces.
  const_cast<Epetra_FECrsGraph &>(pattern.trilinos_sparsity_pattern()).SortGhostsAssociatedWithEachProcessor(true);
  std::vector<dealii::types::global_dof_index> columns;
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node) {
    columns.clear();
    for (const unsigned neighbour : neighbours[node])
      for (unsigned j = 0; j < c; ++j)
        columns.push_back(space.global_node(neighbour) * c + j);
    std::sort(columns.begin(), columns.end());
    for (unsigned i = 0; i < c; ++i)
      pattern.add_entries(space.global_node(node) * c + i, columns.begin(), columns.end(), true);
  }
  pattern.compress();
  matrix_.reinit(pattern);

  // deal.II hands Trilinos' matrix out as const only, but filling its value array in place is what Epetra offers it for.
  auto &crs = const_cast<Epetra_CrsMatrix &>(matrix_.trilinos_matrix());
  crs.ExtractCrsDataPointers(row_begin_, columns_, values_);
  n_rows_ = crs.NumMyRows();

  std::vector<int> column_of_node(space.n_local_nodes());
  for (unsigned node = 0; node < space.n_local_nodes(); ++node)
    column_of_node[node] = crs.ColMap().LID(static_cast<int>(space.global_node(node) * c));
  positions_.assign(std::size_t(space.n_slots()) * n * n, -1);
  for (unsigned slot = 0; slot < space.n_slots(); ++slot)
    for (unsigned a = 0; a < n; ++a) {
      const unsigned row = space.cell_nodes(slot)[a];
      if (row >= space.n_owned_nodes())
        continue;
      const int *first = columns_ + row_begin_[row * c], *last = columns_ + row_begin_[row * c + 1];
      for (unsigned b = 0; b < n; ++b) {
        const int column = column_of_node[space.cell_nodes(slot)[b]];
        const int *found = std::lower_bound(first, last, column);
        if (found == last || *found != column || found[c - 1] != column + int(c) - 1)
          throw std::logic_error("columns of a node are not contiguous in Trilinos' numbering");
        positions_[(std::size_t(slot) * n + a) * n + b] = found - first;
      }
    }
  slot_constrained_.assign(space.n_slots(), 0);
  collect_blocks();
}

void NodalMatrix::set_constraints(const std::vector<std::uint8_t> &constrained) {
  constrained_ = constrained;
  const unsigned n = space_.nodes_per_cell(), c = components_;
  for (unsigned slot = 0; slot < space_.n_slots(); ++slot) {
    slot_constrained_[slot] = 0;
    if (!constrained_.empty())
      for (unsigned k = 0; k < n * c; ++k)
        slot_constrained_[slot] |= constrained_[space_.cell_nodes(slot)[k / c] * c + k % c];
  }
}

void NodalMatrix::clear() { std::fill(values_, values_ + row_begin_[n_rows_], 0.0); }

void NodalMatrix::constrain(unsigned batch, Lanes *K) const {
  const unsigned n = space_.nodes_per_cell(), c = components_;
  for (unsigned lane = 0; lane < n_lanes; ++lane) {
    const unsigned slot = batch * n_lanes + lane, *nodes = space_.cell_nodes(slot);
    if (!slot_constrained_[slot])
      continue;
    for (unsigned k = 0; k < n * c; ++k)
      if (constrained_[nodes[k / c] * c + k % c])
        for (unsigned l = 0; l < n * c; ++l)
          if (l != k) {
            const unsigned a = k / c, i = k % c, b = l / c, j = l % c;
            K[((a * n + b) * c + i) * c + j][lane] = 0;
            K[((b * n + a) * c + j) * c + i][lane] = 0;
          }
  }
}

void NodalMatrix::add_batch(unsigned batch, Lanes *K) {
  const unsigned n = space_.nodes_per_cell(), c = components_;
  constrain(batch, K);
  BatchRows rows{n, c, 0, {}, {}, {}, {}};
  for (unsigned a = 0; a < n; ++a) {
    const Lanes *K_a = K + a * n * c * c;
    rows.n_used = 0;
    visit_rows(batch, a, [&](unsigned lane, unsigned node, const int *positions) {
      const unsigned row = node * c, k = rows.n_used++;
      rows.lane[k] = lane;
      rows.row[k] = values_ + row_begin_[row];
      rows.length[k] = row_begin_[row + 1] - row_begin_[row];
      rows.position[k] = positions;
    });
    insert_rows(rows, K_a);
  }
}

void NodalMatrix::add_block(unsigned slot, unsigned a, unsigned b, const double *block) {
  const unsigned c = components_, *nodes = space_.cell_nodes(slot);
  const int first = position(slot, a, b);
  if (first < 0)
    return;
  for (unsigned i = 0; i < c; ++i)
    for (unsigned j = 0; j < c; ++j)
      if (couples(nodes[a] * c + i, nodes[b] * c + j))
        values_[row_begin_[nodes[a] * c + i] + first + j] += block[i * c + j];
}

void NodalMatrix::add_diagonal(unsigned local_dof, double value) {
  if (local_dof >= unsigned(n_rows_))
    return;
  const int *first = columns_ + row_begin_[local_dof], *last = columns_ + row_begin_[local_dof + 1];
  // Owned columns come first in Trilinos' numbering, in the order of the rows.
  values_[std::lower_bound(first, last, int(local_dof)) - columns_] += value;
}

void NodalMatrix::vmult(Vector &y, const Vector &x) const {
  const GhostValues ghosts(x);
  multiply({components_, n_rows_ / int(components_), row_begin_, values_, block_begin_.data(), block_columns_.data()},
           x.begin(), y.begin());
}

void NodalMatrix::vmult_threefold(Vector &y, const Vector &x) const {
  const GhostValues ghosts(x);
  fours_.resize(4 * std::size_t(space_.n_local_nodes()));
  for (unsigned k = 0; k < 3 * space_.n_local_nodes(); ++k)
    fours_[k / 3 * 4 + k % 3] = x.begin()[k];
  multiply_threefold({1, n_rows_, row_begin_, values_, block_begin_.data(), block_columns_.data()}, fours_.data(),
                     y.begin());
}

/// Trilinos numbers ghost columns its own way; the product reads them where deal.II's vectors have them.
void NodalMatrix::collect_blocks() {
  const Epetra_BlockMap &columns = matrix_.trilinos_matrix().ColMap();
  const auto partitioner = space_.partitioner(1);
  block_begin_.push_back(0);
  for (int row = 0; row < n_rows_; row += components_) {
    for (int k = row_begin_[row]; k < row_begin_[row + 1]; k += components_)
      block_columns_.push_back(int(partitioner->global_to_local(columns.GID(columns_[k]) / components_)));
    block_begin_.push_back(int(block_columns_.size()));
  }
}

std::shared_ptr<const FactorPattern> NodalMatrix::factor_pattern() const {
  if (!factor_pattern_)
    factor_pattern_ = std::make_shared<const FactorPattern>(*this);
  return factor_pattern_;
}

int NodalMatrix::column_of(unsigned local_dof) const {
  return matrix_.trilinos_matrix().ColMap().LID(
      static_cast<int>(space_.global_node(local_dof / components_) * components_ + local_dof % components_));
}

int NodalMatrix::position_of(int row, int column) const {
  const int *first = columns_ + row_begin_[row], *last = columns_ + row_begin_[row + 1];
  const int *found = std::lower_bound(first, last, column);
  return found != last && *found == column ? int(found - columns_) : -1;
}

double NodalMatrix::entry(unsigned local_row, unsigned local_column) const {
  const int position = position_of(local_row, column_of(local_column));
  return position >= 0 ? values_[position] : 0.0;
}

void NodalMatrix::add_block(unsigned node, unsigned column_node, const double *block) {
  const unsigned c = components_;
  const int column = column_of(column_node * c);
  for (unsigned i = 0; i < c; ++i)
    if (const int position = position_of(node * c + i, column); position >= 0)
      for (unsigned j = 0; j < c; ++j)
        if (couples(node * c + i, column_node * c + j))
          values_[position + j] += block[i * c + j];
}

void NodalMatrix::decouple(const std::vector<std::uint8_t> &dofs) {
  std::vector<std::uint8_t> column_flags(matrix_.trilinos_matrix().ColMap().NumMyElements(), 0);
  for (unsigned dof = 0; dof < dofs.size(); ++dof)
    if (const int column = column_of(dof); dofs[dof] && column >= 0)
      column_flags[column] = 1;
  for (int row = 0; row < n_rows_; ++row)
    for (int k = row_begin_[row]; k < row_begin_[row + 1]; ++k)
      if (columns_[k] != row && (dofs[row] || column_flags[columns_[k]]))
        values_[k] = 0;
}

void NodalMatrix::diagonal(Vector &d) const {
  for (int row = 0; row < n_rows_; ++row) {
    const int *first = columns_ + row_begin_[row], *last = columns_ + row_begin_[row + 1];
    d.local_element(row) = values_[std::lower_bound(first, last, row) - columns_];
  }
}

void NodalMatrix::copy_scaled(double a, const NodalMatrix &other) {
  std::transform(other.values_, other.values_ + row_begin_[n_rows_], values_, [a](double v) { return a * v; });
}

void NodalMatrix::add_scaled(double a, const NodalMatrix &other) {
  std::transform(values_, values_ + row_begin_[n_rows_], other.values_, values_,
                 [a](double v, double w) { return v + a * w; });
}

void zero_constrained(Vector &v, const std::vector<std::uint8_t> &constrained) {
  if (!constrained.empty())
    for (unsigned i = 0; i < v.locally_owned_size(); ++i)
      if (constrained[i])
        v.local_element(i) = 0;
}

} // namespace heartbus::fem
