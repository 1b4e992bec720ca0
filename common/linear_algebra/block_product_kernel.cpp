#include "common/linear_algebra/block_product_kernel.h"

#include "common/linear_algebra/block_products.h"
#include "common/simd/sparse_dot.h"

namespace heartbus::fem {
namespace {

template <unsigned b>
HEARTBUS_INLINE void multiply_blocks(const BlockRows &A, const double *x, double *y) {
  for (int i = 0; i < A.n_nodes; ++i) {
    const int *columns = A.block_columns + A.block_begin[i];
    const int n_blocks = A.block_begin[i + 1] - A.block_begin[i];
    const double *row[b];
    for (unsigned r = 0; r < b; ++r)
      row[r] = A.values + A.row_begin[b * i + r];
    double sum[b][b] = {}; // [row][column within the block]: no sum across lanes until the end
    for (int k = 0; k < n_blocks; ++k) {
      prefetch_ahead(row[0] + b * b * k, b * b);
      const double *x_block = x + b * columns[k];
      for (unsigned r = 0; r < b; ++r)
        for (unsigned c = 0; c < b; ++c)
          sum[r][c] += row[r][b * k + c] * x_block[c];
    }
    for (unsigned r = 0; r < b; ++r) {
      double total = 0;
      for (unsigned c = 0; c < b; ++c)
        total += sum[r][c];
      y[b * i + r] = total;
    }
  }
}

template <>
HEARTBUS_INLINE void multiply_blocks<1>(const BlockRows &A, const double *x, double *y) {
  for (int i = 0; i < A.n_nodes; ++i) {
    y[i] = sparse_dot(A.values + A.row_begin[i], A.block_columns + A.block_begin[i],
                      A.block_begin[i + 1] - A.block_begin[i], x);
  }
}

template <>
HEARTBUS_INLINE void multiply_blocks<4>(const BlockRows &A, const double *x, double *y) {
  for (int i = 0; i < A.n_nodes; ++i) {
    const int *columns = A.block_columns + A.block_begin[i];
    const int n_blocks = A.block_begin[i + 1] - A.block_begin[i];
    const double *row = A.values + A.row_begin[4 * i];
    const long length = 4 * n_blocks;
    Double4 sums[4] = {};
    for (int k = 0; k < n_blocks; ++k) {
      prefetch_ahead(row + 16 * k, 16);
      const Double4 x_block = load4(x + 4 * columns[k]);
      for (unsigned r = 0; r < 4; ++r)
        sums[r] += load4(row + r * length + 4 * k) * x_block;
    }
    for (unsigned r = 0; r < 4; ++r)
      y[4 * i + r] = sums[r][0] + sums[r][1] + sums[r][2] + sums[r][3];
  }
}

template <unsigned b>
HEARTBUS_INLINE void multiply_rounded_blocks(const RoundedRows &A, const double *x, double *y) {
  for (int i = 0; i < A.n_nodes; ++i) {
    const Double4 sums = block_products<b>(A.values, A.columns, A.begin[i], A.begin[i + 1], x);
    for (unsigned r = 0; r < b; ++r)
      y[b * i + r] = sums[r];
  }
}

} // namespace

HEARTBUS_SIMD void multiply(const BlockRows &A, const double *x, double *y) {
  switch (A.b) {
  case 1:
    return multiply_blocks<1>(A, x, y);
  case 3:
    return multiply_blocks<3>(A, x, y);
  default:
    return multiply_blocks<4>(A, x, y);
  }
}

HEARTBUS_SIMD void multiply_threefold(const BlockRows &A, const double *x, double *y) {
  for (int i = 0; i < A.n_nodes; ++i) {
    const Double4 sums = sparse_dot_of_fours(A.values + A.row_begin[i], A.block_columns + A.block_begin[i],
                                             A.block_begin[i + 1] - A.block_begin[i], x);
    for (unsigned c = 0; c < 3; ++c)
      y[3 * i + c] = sums[c];
  }
}

HEARTBUS_SIMD void multiply_rounded(const RoundedRows &A, const double *x, double *y) {
  if (A.b == 3)
    return multiply_rounded_blocks<3>(A, x, y);
  if (A.b == 4)
    return multiply_rounded_blocks<4>(A, x, y);
  for (int i = 0; i < A.n_nodes; ++i)
    y[i] = sparse_dot(A.values + A.begin[i], A.columns + A.begin[i], A.begin[i + 1] - A.begin[i], x);
}

} // namespace heartbus::fem
