#pragma once

namespace heartbus::fem {

/// The factors of an incomplete LU decomposition of b x b blocks, in the order of their use, so that a solution reads
/// them as one stream: the rows of L downwards, without their diagonal of ones, then the rows of U upwards, each with
/// the inverse of its diagonal block at its end. A row holds the blocks up to `end` of it, each column by column.
struct BlockFactors {
  unsigned b; ///< 1, 3 or 4
  int n_rows;
  const int *end; ///< [2 n_rows]
  const int *columns;
  const float *factors; ///< and one number more, which is loaded but not used
};

/// The rows of a matrix of b x b blocks that are to be factorised, with those of the ghosts; each block column by
/// column.
struct RowsWithGhosts {
  int n_ghosts;                ///< the first rows, whose blocks are in `ghosts`; those of the others are in `owned`
  const int *begin, *columns;  ///< [n_rows + 1]; sorted within a row, with the diagonal
  const int *sources;          ///< of each block: its number in its array
  const float *owned, *ghosts; ///< and one number more, which is loaded but not used
};

/// Fills `values`, the factors of `factors`, without fill: only blocks that the rows have are kept. Returns whether all
/// pivots were finite.
bool factorise_blocks(const RowsWithGhosts &rows, const BlockFactors &factors, float *values);

/// Numbers of a row in the work vector.
constexpr unsigned work_length(unsigned b) { return b == 1 ? 1 : 4; }

/// y = U^-1 L^-1 x but for the first n_ghosts rows, which y has not and which come last in x; b numbers a row. `work`
/// holds work_length(b) numbers a row.
void solve_block_ilu(const BlockFactors &ilu, int n_ghosts, const double *x, double *y, double *work);

/// The same for three vectors side by side, x[3 i + c], and b = 1. `work` holds four numbers a row.
void solve_ilu_3rhs(const BlockFactors &ilu, int n_ghosts, const double *x, double *y, double *work);

} // namespace heartbus::fem
