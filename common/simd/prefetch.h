#pragma once

#include "common/simd/vectorized_double.h"

namespace heartbus::fem {

/// Asks for the n numbers that will be read 8 kB after these. The rows of a matrix are read side by side, and the
/// processor foresees too little of that: from memory, products are twice to three times as fast with this.
template <class Number>
HEARTBUS_INLINE void prefetch_ahead(const Number *now, int n) {
  constexpr int distance = 8192 / sizeof(Number), line = 64 / sizeof(Number);
  for (int k = 0; k + line / 2 <= n; k += line)
    __builtin_prefetch(now + distance + k);
}

} // namespace heartbus::fem
