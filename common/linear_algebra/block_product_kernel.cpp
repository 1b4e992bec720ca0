#include "common/linear_algebra/block_product_kernel.h"

#include "common/linear_algebra/block_products.h"
#include "common/simd/sparse_dot.h"

namespace heartbus::fem {
namespace {

template <unsigned b, class Number>
HEARTBUS_INLINE void multiply_blocks(const BlockRows<Number> &A, const double *x, double *y) {
  for (int i = 0; i < A.n_nodes; ++i) {
    const Double4 sums = block_products<b>(A.values, A.columns, A.begin[i], A.begin[i + 1], x);
    for (unsigned r = 0; r < b; ++r)
      y[b * i + r] = sums[r];
  }
}

template <class Number>
HEARTBUS_INLINE void product(const BlockRows<Number> &A, const double *x, double *y) {
  if (A.b == 3)
    return multiply_blocks<3>(A, x, y);
  if (A.b == 4)
    return multiply_blocks<4>(A, x, y);
  for (int i = 0; i < A.n_nodes; ++i)
    y[i] = sparse_dot(A.values + A.begin[i], A.columns + A.begin[i], A.begin[i + 1] - A.begin[i], x);
}

template <class Number>
HEARTBUS_INLINE void product_3rhs(const BlockRows<Number> &A, const double *x, double *y) {
  for (int i = 0; i < A.n_nodes; ++i) {
    const Double4 sums =
        sparse_dot_of_fours(A.values + A.begin[i], A.columns + A.begin[i], A.begin[i + 1] - A.begin[i], x);
    for (unsigned c = 0; c < 3; ++c)
      y[3 * i + c] = sums[c];
  }
}

} // namespace

HEARTBUS_SIMD void multiply(const BlockRows<double> &A, const double *x, double *y) { product(A, x, y); }

HEARTBUS_SIMD void multiply(const BlockRows<float> &A, const double *x, double *y) { product(A, x, y); }

HEARTBUS_SIMD void multiply_3rhs(const BlockRows<double> &A, const double *x, double *y) { product_3rhs(A, x, y); }

HEARTBUS_SIMD void multiply_3rhs(const BlockRows<float> &A, const double *x, double *y) { product_3rhs(A, x, y); }

} // namespace heartbus::fem
