#pragma once

namespace heartbus::fluid {

/// The factors of an incomplete LU decomposition of 4x4 blocks, rows compressed: [begin[i], begin[i + 1]) are the blocks of
/// row i, sorted by column; those before diagonal[i] belong to L (unit diagonal), those behind it to U; the block at
/// diagonal[i] is the inverse of U's. Blocks are stored column by column.
struct BlockFactors {
  int n_rows;
  const int *begin, *diagonal, *columns;
  const float *factors;
};

/// y = U^-1 L^-1 x; four numbers a row.
void solve_block_ilu(const BlockFactors &ilu, const double *x, double *y);

} // namespace heartbus::fluid
