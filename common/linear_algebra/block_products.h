#pragma once

#include "common/simd/fours.h"
#include "common/simd/prefetch.h"

namespace heartbus::fem {

/// The sum of the products of blocks [first, last) with the fours of z that their columns name. Blocks are stored
/// column by column. One sum a column of the blocks: a single one would wait for each addition to end. With three
/// components the fourth number is never used.
template <unsigned b, class Number>
HEARTBUS_INLINE Double4 block_products(const Number *blocks, const int *columns, int first, int last, const double *z) {
  Double4 sums[b] = {};
  for (int k = first; k < last; ++k) {
    const Number *block = blocks + long(b * b) * k;
    prefetch_ahead(block, b * b);
    const Double4 v = load4(z + 4 * columns[k]);
    for (unsigned j = 0; j < b; ++j)
      sums[j] += load4(block + b * j) * v[j];
  }
  for (unsigned j = 1; j < b; ++j)
    sums[0] += sums[j];
  return sums[0];
}

} // namespace heartbus::fem
