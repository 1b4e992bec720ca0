#include "common/fem/block_ilu_kernel.h"

#include "common/fem/lanes.h"
#include "common/fem/sparse_dot.h"

#include <algorithm>

namespace heartbus::fem {
namespace {

// Four numbers of a node or of a block's column; aligned like their parts, so that they can lie anywhere in an array.
typedef float Float4 __attribute__((vector_size(16), aligned(4)));
typedef double Double4 __attribute__((vector_size(32), aligned(8)));

HEARTBUS_INLINE Double4 widened(Float4 numbers) { return __builtin_convertvector(numbers, Double4); }

/// A block times the numbers of a node.
template <unsigned b>
HEARTBUS_INLINE Double4 product(const float *block, const Double4 &v) {
  const auto *columns = reinterpret_cast<const Float4 *>(block);
  Double4 sum{};
  for (unsigned j = 0; j < b; ++j)
    sum += widened(columns[j]) * v[j];
  return sum;
}

/// The sum over blocks [first, last) of their products. One sum a column of the blocks: a single one would wait for each
/// addition to end.
template <unsigned b>
HEARTBUS_INLINE Double4 products(const BlockFactors &ilu, int first, int last, const Double4 *z) {
  Double4 sums[b] = {};
  for (int k = first; k < last; ++k) {
    const auto *columns = reinterpret_cast<const Float4 *>(ilu.factors + long(4 * b) * k);
    const Double4 v = z[ilu.columns[k]];
    for (unsigned j = 0; j < b; ++j)
      sums[j] += widened(columns[j]) * v[j];
  }
  for (unsigned j = 1; j < b; ++j)
    sums[0] += sums[j];
  return sums[0];
}

template <unsigned b>
HEARTBUS_INLINE Double4 load(const double *x) {
  Double4 v{};
  for (unsigned i = 0; i < b; ++i)
    v[i] = x[i];
  return v;
}

template <unsigned b>
HEARTBUS_INLINE void solve(const BlockFactors &ilu, int n_kept, const double *x, double *y, double *work) {
  auto *z = reinterpret_cast<Double4 *>(work);
  for (int i = 0; i < ilu.n_rows; ++i)
    z[i] = load<b>(x + b * i) - products<b>(ilu, ilu.begin[i], ilu.diagonal[i], z);
  for (int i = ilu.n_rows - 1; i >= 0; --i) {
    z[i] = product<b>(ilu.factors + long(4 * b) * ilu.diagonal[i],
                      z[i] - products<b>(ilu, ilu.diagonal[i] + 1, ilu.begin[i + 1], z));
    if (i < n_kept)
      for (unsigned j = 0; j < b; ++j)
        y[b * i + j] = z[i][j];
  }
}

template <>
HEARTBUS_INLINE void solve<1>(const BlockFactors &ilu, int n_kept, const double *x, double *y, double *z) {
  const auto products = [&](int first, int last) {
    return sparse_dot(ilu.factors + first, ilu.columns + first, last - first, z);
  };
  for (int i = 0; i < ilu.n_rows; ++i)
    z[i] = x[i] - products(ilu.begin[i], ilu.diagonal[i]);
  for (int i = ilu.n_rows - 1; i >= 0; --i)
    z[i] = ilu.factors[ilu.diagonal[i]] * (z[i] - products(ilu.diagonal[i] + 1, ilu.begin[i + 1]));
  std::copy_n(z, n_kept, y);
}

} // namespace

HEARTBUS_SIMD void solve_block_ilu(const BlockFactors &ilu, int n_kept, const double *x, double *y, double *work) {
  switch (ilu.b) {
  case 1:
    return solve<1>(ilu, n_kept, x, y, work);
  case 3:
    return solve<3>(ilu, n_kept, x, y, work);
  default:
    return solve<4>(ilu, n_kept, x, y, work);
  }
}

} // namespace heartbus::fem
