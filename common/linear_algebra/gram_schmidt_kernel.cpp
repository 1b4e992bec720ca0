#include "common/linear_algebra/gram_schmidt_kernel.h"

#include "common/simd/vectorized_double.h"

#include <algorithm>
#include <cstring>

namespace heartbus::fem {
namespace {

constexpr long piece = 1024; ///< of w, which stays in the innermost cache while the basis passes

HEARTBUS_INLINE VectorizedDouble load(const double *from) {
  VectorizedDouble x;
  std::memcpy(&x, from, sizeof x);
  return x;
}

/// Four sums at once: a single one would wait for each addition to end.
HEARTBUS_INLINE double dot(long n, const double *x, const double *y) {
  VectorizedDouble sums[4] = {};
  long i = 0;
  for (; i + 4 * long(n_lanes) <= n; i += 4 * n_lanes)
    for (unsigned k = 0; k < 4; ++k)
      sums[k] += load(x + i + k * n_lanes) * load(y + i + k * n_lanes);
  double rest = 0;
  for (; i < n; ++i)
    rest += x[i] * y[i];
  const VectorizedDouble sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
  return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + rest;
}

HEARTBUS_INLINE void subtract(long n, double factor, const double *x, double *y) {
  long i = 0;
  for (; i + long(n_lanes) <= n; i += n_lanes) {
    const VectorizedDouble difference = load(y + i) - factor * load(x + i);
    std::memcpy(y + i, &difference, sizeof difference);
  }
  for (; i < n; ++i)
    y[i] -= factor * x[i];
}

} // namespace

HEARTBUS_SIMD void multiply_by_basis(long n, const std::vector<const double *> &basis, const double *w,
                                     std::vector<double> &products) {
  const std::size_t k = basis.size();
  products.assign(k + 1, 0);
  for (long begin = 0; begin < n; begin += piece) {
    const long length = std::min(piece, n - begin);
    for (std::size_t j = 0; j <= k; ++j)
      products[j] += dot(length, (j < k ? basis[j] : w) + begin, w + begin);
  }
}

HEARTBUS_SIMD void subtract_basis(long n, const std::vector<const double *> &basis, const double *factors, double *w) {
  for (long begin = 0; begin < n; begin += piece)
    for (std::size_t j = 0; j < basis.size(); ++j)
      subtract(std::min(piece, n - begin), factors[j], basis[j] + begin, w + begin);
}

} // namespace heartbus::fem
