#pragma once

#include "common/simd/fours.h"

namespace heartbus::fem {

/// Sum over k of values[k] x[columns[k]]. Four sums at once: a single one would wait for each addition to end.
template <class Number>
HEARTBUS_INLINE double sparse_dot(const Number *values, const int *columns, int n, const double *x) {
  double sums[4] = {};
  int k = 0;
  for (; k + 4 <= n; k += 4)
    for (int i = 0; i < 4; ++i)
      sums[i] += values[k + i] * x[columns[k + i]];
  for (; k < n; ++k)
    sums[0] += values[k] * x[columns[k]];
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

/// The same for x of four numbers a row, which share the matrix.
template <class Number>
HEARTBUS_INLINE Double4 sparse_dot_of_fours(const Number *values, const int *columns, int n, const double *x) {
  Double4 sums[4] = {};
  int k = 0;
  for (; k + 4 <= n; k += 4)
    for (int i = 0; i < 4; ++i)
      sums[i] += double(values[k + i]) * load4(x + 4 * columns[k + i]);
  for (; k < n; ++k)
    sums[0] += double(values[k]) * load4(x + 4 * columns[k]);
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

} // namespace heartbus::fem
