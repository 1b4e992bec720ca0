#pragma once

#include "common/fem/lanes.h"

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

} // namespace heartbus::fem
