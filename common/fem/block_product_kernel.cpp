#include "common/fem/block_product_kernel.h"

#include "common/fem/lanes.h"

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
