#pragma once

namespace heartbus::fem {

/// The factors of an incomplete LU decomposition of b x b blocks, rows compressed: [begin[i], begin[i + 1]) are the blocks
/// of row i, sorted by column; those before diagonal[i] belong to L (unit diagonal), those behind it to U; the block at
/// diagonal[i] is the inverse of U's. Blocks are stored column by column, each column padded to `column_length(b)`.
struct BlockFactors {
  unsigned b; ///< 1, 3 or 4
  int n_rows;
  const int *begin, *diagonal, *columns;
  const float *factors;
};

/// Numbers a column of a block and a row of the work vector take: that of a vector register.
constexpr unsigned column_length(unsigned b) { return b == 1 ? 1 : 4; }

/// y = U^-1 L^-1 x, of which the first n_kept rows are written; b numbers a row. `work` holds column_length(b) numbers a row.
void solve_block_ilu(const BlockFactors &ilu, int n_kept, const double *x, double *y, double *work);

} // namespace heartbus::fem
