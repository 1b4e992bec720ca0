#include "common/fem/block_ilu_kernel.h"

#include "common/fem/block_products.h"
#include "common/fem/sparse_dot.h"

#include <algorithm>

namespace heartbus::fem {
namespace {

template <unsigned b>
HEARTBUS_INLINE Double4 products(const BlockFactors &ilu, int first, int last, const double *z) {
  return block_products<b>(ilu.factors, ilu.columns, first, last, z);
}

template <unsigned b>
HEARTBUS_INLINE Double4 load(const double *x) {
  Double4 v{};
  for (unsigned i = 0; i < b; ++i)
    v[i] = x[i];
  return v;
}

template <unsigned b>
HEARTBUS_INLINE void solve(const BlockFactors &ilu, int n_kept, const double *x, double *y, double *z) {
  int first = 0;
  for (int i = 0; i < ilu.n_rows; first = ilu.end[i++]) {
    store4(z + 4 * i, load<b>(x + b * i) - products<b>(ilu, first, ilu.end[i], z));
  }
  for (int row = ilu.n_rows; row < 2 * ilu.n_rows; first = ilu.end[row++]) {
    const int i = 2 * ilu.n_rows - 1 - row, diagonal = ilu.end[row] - 1;
    store4(z + 4 * i, load4(z + 4 * i) - products<b>(ilu, first, diagonal, z));
    const Double4 solution = products<b>(ilu, diagonal, diagonal + 1, z);
    store4(z + 4 * i, solution);
    if (i < n_kept)
      for (unsigned j = 0; j < b; ++j)
        y[b * i + j] = solution[j];
  }
}

template <>
HEARTBUS_INLINE void solve<1>(const BlockFactors &ilu, int n_kept, const double *x, double *y, double *z) {
  const auto products = [&](int first, int last) {
    return sparse_dot(ilu.factors + first, ilu.columns + first, last - first, z);
  };
  int first = 0;
  for (int i = 0; i < ilu.n_rows; first = ilu.end[i++])
    z[i] = x[i] - products(first, ilu.end[i]);
  for (int row = ilu.n_rows; row < 2 * ilu.n_rows; first = ilu.end[row++]) {
    const int i = 2 * ilu.n_rows - 1 - row, diagonal = ilu.end[row] - 1;
    z[i] = ilu.factors[diagonal] * (z[i] - products(first, diagonal));
  }
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

HEARTBUS_SIMD void solve_ilu_threefold(const BlockFactors &ilu, int n_kept, const double *x, double *y, double *z) {
  const auto products = [&](int first, int last) {
    return sparse_dot_of_fours(ilu.factors + first, ilu.columns + first, last - first, z);
  };
  int first = 0;
  for (int i = 0; i < ilu.n_rows; first = ilu.end[i++])
    store4(z + 4 * i, load<3>(x + 3 * i) - products(first, ilu.end[i]));
  for (int row = ilu.n_rows; row < 2 * ilu.n_rows; first = ilu.end[row++]) {
    const int i = 2 * ilu.n_rows - 1 - row, diagonal = ilu.end[row] - 1;
    const Double4 solution = double(ilu.factors[diagonal]) * (load4(z + 4 * i) - products(first, diagonal));
    store4(z + 4 * i, solution);
    for (unsigned c = 0; c < 3 && i < n_kept; ++c)
      y[3 * i + c] = solution[c];
  }
}

} // namespace heartbus::fem
