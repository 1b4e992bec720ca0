#include "common/fem/block_product_kernel.h"

#include "common/fem/lanes.h"
#include "common/fem/sparse_dot.h"

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
  for (int i = 0; i < A.n_nodes; ++i)
    y[i] = sparse_dot(A.values + A.row_begin[i], A.block_columns + A.block_begin[i], A.block_begin[i + 1] - A.block_begin[i],
                      x);
}

/// Four numbers of a block's row, anywhere in an array.
typedef double Double4 __attribute__((vector_size(32), aligned(8)));

template <>
HEARTBUS_INLINE void multiply_blocks<4>(const BlockRows &A, const double *x, double *y) {
  for (int i = 0; i < A.n_nodes; ++i) {
    const auto *row0 = reinterpret_cast<const Double4 *>(A.values + A.row_begin[4 * i]);
    const auto *row1 = reinterpret_cast<const Double4 *>(A.values + A.row_begin[4 * i + 1]);
    const auto *row2 = reinterpret_cast<const Double4 *>(A.values + A.row_begin[4 * i + 2]);
    const auto *row3 = reinterpret_cast<const Double4 *>(A.values + A.row_begin[4 * i + 3]);
    Double4 sum0{}, sum1{}, sum2{}, sum3{};
    const int *columns = A.block_columns + A.block_begin[i];
    for (int k = 0; k < A.block_begin[i + 1] - A.block_begin[i]; ++k) {
      const Double4 x_block = *reinterpret_cast<const Double4 *>(x + 4 * columns[k]);
      sum0 += row0[k] * x_block;
      sum1 += row1[k] * x_block;
      sum2 += row2[k] * x_block;
      sum3 += row3[k] * x_block;
    }
    const auto total = [](const Double4 &sum) { return sum[0] + sum[1] + sum[2] + sum[3]; };
    y[4 * i] = total(sum0);
    y[4 * i + 1] = total(sum1);
    y[4 * i + 2] = total(sum2);
    y[4 * i + 3] = total(sum3);
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

} // namespace heartbus::fem
