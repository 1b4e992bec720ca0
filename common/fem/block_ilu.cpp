#include "common/fem/block_ilu.h"

#include "common/bus/failure.h"

#include <array>
#include <cmath>

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

} // namespace

BlockILU::BlockILU(const NodalMatrix &matrix) : components_(matrix.components()) {
  copy_pattern(matrix);
  work_.resize(column_length(components_) * diagonal_.size());
  if (components_ == 1)
    factorise<1>(matrix);
  else if (components_ == 3)
    factorise<3>(matrix);
  else
    factorise<4>(matrix);
}

/// The blocks between owned nodes. The rows of a node have one pattern, and owned columns come first in it.
void BlockILU::copy_pattern(const NodalMatrix &matrix) {
  const int b = int(components_);
  begin_.push_back(0);
  for (int node = 0; node < matrix.n_rows() / b; ++node) {
    for (int k = matrix.row_begin()[b * node]; k < matrix.row_begin()[b * node + 1]; k += b)
      if (const int column = matrix.columns()[k]; column < matrix.n_rows()) {
        if (column / b == node)
          diagonal_.push_back(int(columns_.size()));
        columns_.push_back(column / b);
      }
    begin_.push_back(int(columns_.size()));
  }
}

template <unsigned b>
void BlockILU::factorise(const NodalMatrix &matrix) {
  std::vector<Block<b>> blocks(columns_.size());
  const int n = int(diagonal_.size());
  std::vector<int> position(n, -1); // of the blocks of the current row
  for (int i = 0; i < n; ++i) {
    for (int k = begin_[i]; k < begin_[i + 1]; ++k) {
      position[columns_[k]] = k;
      for (unsigned row = 0; row < b; ++row)
        std::copy_n(matrix.values() + matrix.row_begin()[b * i + row] + b * (k - begin_[i]), b, &blocks[k][b * row]);
    }
    for (int k = begin_[i]; k < diagonal_[i]; ++k) {
      const int pivot_row = columns_[k];
      Block<b> L{};
      subtract_product<b>(L, blocks[k], blocks[diagonal_[pivot_row]]);
      for (double &value : L)
        value = -value;
      blocks[k] = L;
      for (int j = diagonal_[pivot_row] + 1; j < begin_[pivot_row + 1]; ++j)
        if (const int target = position[columns_[j]]; target >= 0)
          subtract_product<b>(blocks[target], L, blocks[j]);
    }
    blocks[diagonal_[i]] = inverse<b>(blocks[diagonal_[i]]);
    for (int k = begin_[i]; k < begin_[i + 1]; ++k)
      position[columns_[k]] = -1;
  }
  constexpr unsigned length = column_length(b);
  factors_.assign(b * length * blocks.size(), 0);
  for (std::size_t k = 0; k < blocks.size(); ++k)
    for (unsigned i = 0; i < b; ++i)
      for (unsigned j = 0; j < b; ++j)
        factors_[(k * b + j) * length + i] = float(blocks[k][b * i + j]);
}

void BlockILU::vmult(Vector &y, const Vector &x) const {
  solve_block_ilu({components_, int(diagonal_.size()), begin_.data(), diagonal_.data(), columns_.data(), factors_.data()},
                  x.begin(), y.begin(), work_.data());
}

} // namespace heartbus::fem
