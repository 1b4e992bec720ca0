#include "common/linear_algebra/block_matrix.h"

#include "common/linear_algebra/insertion_kernel.h"

namespace heartbus::fem {

template <class Number>
BlockMatrix<Number>::BlockMatrix(Pattern pattern, unsigned components)
    : pattern_(std::move(pattern)), components_(components),
      values_(std::size_t(components) * components * pattern_->n_blocks() + 1),
      slot_constrained_(pattern_->space().n_slots()) {}

template <class Number>
void BlockMatrix<Number>::set_constraints(const Constraints &constrained) {
  constrained_ = constrained;
  const unsigned n = space().nodes_per_cell(), c = components_;
  for (unsigned slot = 0; slot < space().n_slots(); ++slot) {
    slot_constrained_[slot] = 0;
    if (!constrained_.empty())
      for (unsigned k = 0; k < n * c; ++k)
        slot_constrained_[slot] |= constrained_[space().cell_nodes(slot)[k / c] * c + k % c];
  }
}

/// Reduces rows and columns of constraints in the cell matrices of a batch to the diagonal.
template <class Number>
void BlockMatrix<Number>::constrain(unsigned batch, VectorizedDouble *K) const {
  const unsigned n = space().nodes_per_cell(), c = components_;
  for (unsigned lane = 0; lane < n_lanes; ++lane) {
    const unsigned slot = batch * n_lanes + lane, *nodes = space().cell_nodes(slot);
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

template <class Number>
void BlockMatrix<Number>::add_batch(unsigned batch, VectorizedDouble *K) {
  const unsigned n = space().nodes_per_cell(), c = components_;
  constrain(batch, K);
  BatchBlocks<Number> blocks{n, c, values_.data(), 0, {}, {}};
  for (unsigned a = 0; a < n; ++a) {
    blocks.n_used = 0;
    for (unsigned lane = 0; lane < n_lanes; ++lane)
      if (const unsigned slot = batch * n_lanes + lane;
          space().slot_used(slot) && pattern_->positions(slot, a)[0] >= 0) {
        blocks.lane[blocks.n_used] = lane;
        blocks.position[blocks.n_used++] = pattern_->positions(slot, a);
      }
    insert_blocks(blocks, K + a * n * c * c);
  }
}

template <class Number>
void BlockMatrix<Number>::add_to(int block, unsigned row_node, unsigned column_node, const double *values) {
  const unsigned c = components_;
  for (unsigned i = 0; i < c && block >= 0; ++i)
    for (unsigned j = 0; j < c; ++j)
      if (couples(row_node * c + i, column_node * c + j))
        values_[place(block, i, j)] += Number(values[i * c + j]);
}

template <class Number>
void BlockMatrix<Number>::add_block(unsigned slot, unsigned a, unsigned b, const double *block) {
  const unsigned *nodes = space().cell_nodes(slot);
  add_to(pattern_->positions(slot, a)[b], nodes[a], nodes[b], block);
}

template <class Number>
void BlockMatrix<Number>::add_block(unsigned node, unsigned column_node, const double *block) {
  add_to(pattern_->find(node, column_node), node, column_node, block);
}

template <class Number>
void BlockMatrix<Number>::add_to_diagonals(unsigned slot, unsigned a, unsigned b, unsigned n, double value) {
  const unsigned c = components_, *nodes = space().cell_nodes(slot);
  const int block = pattern_->positions(slot, a)[b];
  for (unsigned i = 0; i < n && block >= 0; ++i)
    if (couples(nodes[a] * c + i, nodes[b] * c + i))
      values_[place(block, i, i)] += Number(value);
}

template <class Number>
void BlockMatrix<Number>::add_diagonal(unsigned local_dof, double value) {
  const unsigned node = local_dof / components_, i = local_dof % components_;
  if (const int block = pattern_->find(node, node); block >= 0)
    values_[place(block, i, i)] += Number(value);
}

template <class Number>
void BlockMatrix<Number>::decouple(const Constraints &dofs) {
  const unsigned c = components_;
  for (unsigned node = 0; node < unsigned(pattern_->n_rows()); ++node)
    for (int block = pattern_->begin()[node]; block < pattern_->begin()[node + 1]; ++block)
      for (unsigned j = 0; j < c; ++j)
        for (unsigned i = 0; i < c; ++i) {
          const unsigned row = node * c + i, column = pattern_->columns()[block] * c + j;
          if (row != column && (dofs[row] || dofs[column]))
            values_[place(block, i, j)] = 0;
        }
}

template <class Number>
void BlockMatrix<Number>::copy_scaled(double a, const BlockMatrix &other) {
  std::transform(other.values_.begin(), other.values_.end(), values_.begin(), [a](Number v) { return Number(a * v); });
}

template <class Number>
void BlockMatrix<Number>::add_scaled(double a, const BlockMatrix &other) {
  std::transform(values_.begin(), values_.end(), other.values_.begin(), values_.begin(),
                 [a](Number v, Number w) { return Number(v + a * w); });
}

/// Four numbers for each three of x, ghosts included.
template <class Number>
const double *BlockMatrix<Number>::padded(const Vector &x) const {
  padded_.resize(4 * std::size_t(space().n_local_nodes()));
  const double *values = x.begin();
  for (std::size_t node = 0; node < space().n_local_nodes(); ++node)
    for (unsigned i = 0; i < 3; ++i)
      padded_[4 * node + i] = values[3 * node + i];
  return padded_.data();
}

template <class Number>
BlockRows<Number> BlockMatrix<Number>::rows() const {
  return {components_, pattern_->n_rows(), pattern_->begin(), pattern_->columns(), values_.data()};
}

template <class Number>
void BlockMatrix<Number>::vmult(Vector &y, const Vector &x) const {
  const GhostValues ghosts(x);
  multiply(rows(), components_ == 3 ? padded(x) : x.begin(), y.begin());
}

template <class Number>
void BlockMatrix<Number>::vmult_3rhs(Vector &y, const Vector &x) const {
  const GhostValues ghosts(x);
  multiply_3rhs(rows(), padded(x), y.begin());
}

template <class Number>
double BlockMatrix<Number>::entry(unsigned local_row, unsigned local_column) const {
  const unsigned c = components_;
  const int block = pattern_->find(local_row / c, local_column / c);
  return block >= 0 ? double(values_[place(block, local_row % c, local_column % c)]) : 0.0;
}

template <class Number>
void BlockMatrix<Number>::diagonal(Vector &d) const {
  for (unsigned row = 0; row < n_rows(); ++row)
    d.local_element(row) = entry(row, row);
}

template class BlockMatrix<double>;
template class BlockMatrix<float>;

} // namespace heartbus::fem
