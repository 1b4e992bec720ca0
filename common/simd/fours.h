#pragma once

#include "common/simd/vectorized_double.h"

#include <cstring>

namespace heartbus::fem {

/// Four numbers side by side, those of a node or of a row or column of a block, in a register. Loaded and stored by
/// copies, since they lie anywhere in an array: a cast pointer would promise an alignment that is not there.
typedef double Double4 __attribute__((vector_size(32)));

HEARTBUS_INLINE Double4 load4(const double *x) {
  Double4 v;
  std::memcpy(&v, x, sizeof v);
  return v;
}

HEARTBUS_INLINE Double4 load4(const float *x) {
  typedef float Float4 __attribute__((vector_size(16)));
  Float4 v;
  std::memcpy(&v, x, sizeof v);
  return __builtin_convertvector(v, Double4);
}

HEARTBUS_INLINE void store4(double *y, Double4 v) { std::memcpy(y, &v, sizeof v); }

} // namespace heartbus::fem
