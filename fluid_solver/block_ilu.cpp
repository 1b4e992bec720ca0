#include "fluid_solver/block_ilu.h"

#include "common/bus/failure.h"

#include <cmath>

namespace heartbus::fluid {
namespace {

using Block = std::array<double, 16>;

/// c -= a b
void subtract_product(Block &c, const Block &a, const Block &b) {
  for (unsigned i = 0; i < 4; ++i)
    for (unsigned k = 0; k < 4; ++k)
      for (unsigned j = 0; j < 4; ++j)
        c[4 * i + j] -= a[4 * i + k] * b[4 * k + j];
}

/// Gauss-Jordan; the pivots come in order u, v, w, p, each of which is positive in a stabilised problem.
Block inverse(Block a) {
  for (unsigned k = 0; k < 4; ++k) {
    const double pivot = 1 / a[5 * k];
    if (!std::isfinite(pivot))
      throw Failure(ExitCode::not_converged, "Navier-Stokes: the incomplete factorisation met a zero pivot");
    a[5 * k] = 1;
    for (unsigned j = 0; j < 4; ++j)
      a[4 * k + j] *= pivot;
    for (unsigned i = 0; i < 4; ++i)
      if (i != k) {
        const double factor = a[4 * i + k];
        a[4 * i + k] = 0;
        for (unsigned j = 0; j < 4; ++j)
          a[4 * i + j] -= factor * a[4 * k + j];
      }
  }
  return a;
}

} // namespace

BlockILU::BlockILU(const fem::NodalMatrix &matrix) {
  copy_pattern(matrix);
  store(factorise(matrix));
}

/// The blocks between owned nodes. A node's four rows have one pattern, and owned columns come first in it.
void BlockILU::copy_pattern(const fem::NodalMatrix &matrix) {
  begin_.push_back(0);
  for (int node = 0; node < matrix.n_rows() / 4; ++node) {
    for (int k = matrix.row_begin()[4 * node]; k < matrix.row_begin()[4 * node + 1]; k += 4)
      if (const int column = matrix.columns()[k]; column < matrix.n_rows()) {
        if (column / 4 == node)
          diagonal_.push_back(int(columns_.size()));
        columns_.push_back(column / 4);
      }
    begin_.push_back(int(columns_.size()));
  }
}

std::vector<Block> BlockILU::factorise(const fem::NodalMatrix &matrix) const {
  std::vector<Block> blocks(columns_.size());
  const int n = int(diagonal_.size());
  std::vector<int> position(n, -1); // of the blocks of the current row
  for (int i = 0; i < n; ++i) {
    for (int k = begin_[i]; k < begin_[i + 1]; ++k) {
      position[columns_[k]] = k;
      for (int row = 0; row < 4; ++row)
        std::copy_n(matrix.values() + matrix.row_begin()[4 * i + row] + 4 * (k - begin_[i]), 4, &blocks[k][4 * row]);
    }
    for (int k = begin_[i]; k < diagonal_[i]; ++k) {
      const int pivot_row = columns_[k];
      Block L{};
      subtract_product(L, blocks[k], blocks[diagonal_[pivot_row]]);
      for (double &value : L)
        value = -value;
      blocks[k] = L;
      for (int j = diagonal_[pivot_row] + 1; j < begin_[pivot_row + 1]; ++j)
        if (const int target = position[columns_[j]]; target >= 0)
          subtract_product(blocks[target], L, blocks[j]);
    }
    blocks[diagonal_[i]] = inverse(blocks[diagonal_[i]]);
    for (int k = begin_[i]; k < begin_[i + 1]; ++k)
      position[columns_[k]] = -1;
  }
  return blocks;
}

void BlockILU::store(const std::vector<Block> &factors) {
  factors_.reserve(16 * factors.size());
  for (const Block &block : factors)
    for (unsigned j = 0; j < 4; ++j)
      for (unsigned i = 0; i < 4; ++i)
        factors_.push_back(float(block[4 * i + j]));
}

void BlockILU::vmult(fem::Vector &y, const fem::Vector &x) const {
  solve_block_ilu({int(begin_.size()) - 1, begin_.data(), diagonal_.data(), columns_.data(), factors_.data()}, x.begin(),
                  y.begin());
}

} // namespace heartbus::fluid
