#include "common/linear_algebra/rounded_matrix.h"

#include "common/linear_algebra/block_product_kernel.h"
#include "common/linear_algebra/insertion_kernel.h"

#include <algorithm>

namespace heartbus::fem {

RoundedMatrix::RoundedMatrix(const NodalMatrix &matrix)
    : pattern_(matrix), components_(matrix.components()), n_nodes_(matrix.n_rows() / int(components_)), begin_{0} {
  const int c = int(components_), *row_begin = matrix.row_begin();
  columns_.assign(matrix.column_nodes(), matrix.column_nodes() + row_begin[matrix.n_rows()] / (c * c));
  values_.reserve(row_begin[matrix.n_rows()] + 1);
  for (int row = 0; row < matrix.n_rows(); row += c) {
    for (int k = 0; k < row_begin[row + 1] - row_begin[row]; k += c)
      for (int j = 0; j < c; ++j)
        for (int i = 0; i < c; ++i)
          values_.push_back(float(matrix.values()[row_begin[row + i] + k + j]));
    begin_.push_back(int(values_.size()) / (c * c));
  }
  values_.push_back(0); // loaded with the last block
  if (c == 3)
    fours_.resize(4 * std::size_t(matrix.space().n_local_nodes()));
}

void RoundedMatrix::clear() { std::fill(values_.begin(), values_.end(), 0.f); }

void RoundedMatrix::add_batch(unsigned batch, Lanes *K) {
  const LagrangeSpace &space = pattern_.space();
  const unsigned n = space.nodes_per_cell(), c = components_;
  if (c != 4)
    throw std::logic_error("only matrices of four components are assembled in single precision");
  pattern_.constrain(batch, K);
  BatchBlocks blocks{n, 0, {}, {}, {}};
  for (unsigned a = 0; a < n; ++a) {
    const Lanes *K_a = K + a * n * c * c;
    blocks.n_used = 0;
    pattern_.visit_rows(batch, a, [&](unsigned lane, unsigned node, const int *positions) {
      const unsigned k = blocks.n_used++;
      blocks.lane[k] = lane;
      blocks.first[k] = values_.data() + std::size_t(begin_[node]) * c * c;
      blocks.position[k] = positions;
    });
    insert_blocks(blocks, K_a);
  }
}

void RoundedMatrix::add_to_diagonals(unsigned slot, unsigned a, unsigned b, unsigned n, double value) {
  const unsigned c = components_, *nodes = pattern_.space().cell_nodes(slot);
  const int first = pattern_.position(slot, a, b);
  for (unsigned i = 0; i < n && first >= 0; ++i)
    if (pattern_.couples(nodes[a] * c + i, nodes[b] * c + i))
      values_[(std::size_t(begin_[nodes[a]]) * c + first) * c + i * c + i] += float(value);
}

void RoundedMatrix::copy_to(NodalMatrix &matrix) const {
  const int c = int(components_), *row_begin = matrix.row_begin();
  const float *values = values_.data();
  for (int row = 0; row < matrix.n_rows(); row += c)
    for (int k = 0; k < row_begin[row + 1] - row_begin[row]; k += c)
      for (int j = 0; j < c; ++j)
        for (int i = 0; i < c; ++i)
          matrix.values()[row_begin[row + i] + k + j] = *values++;
}

void RoundedMatrix::vmult(Vector &y, const Vector &x) const {
  const GhostValues ghosts(x);
  const double *values = x.begin();
  for (std::size_t node = 0; node < fours_.size() / 4; ++node)
    for (unsigned i = 0; i < 3; ++i)
      fours_[4 * node + i] = values[3 * node + i];
  multiply_rounded({components_, n_nodes_, begin_.data(), columns_.data(), values_.data()},
                   fours_.empty() ? values : fours_.data(), y.begin());
}

} // namespace heartbus::fem
