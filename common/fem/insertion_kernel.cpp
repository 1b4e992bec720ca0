#include "common/fem/insertion_kernel.h"

namespace heartbus::fem {
namespace {

/// Blocks are read once and by all lanes in turn, while they are in the innermost cache.
template <unsigned c>
HEARTBUS_INLINE void insert(const BatchRows &target, const Lanes *K) {
  for (unsigned b = 0; b < target.n_nodes; ++b)
    for (unsigned k = 0; k < target.n_used; ++k) {
      double *block = target.row[k] + target.position[k][b];
      const double *values = reinterpret_cast<const double *>(K + b * c * c) + target.lane[k];
      for (unsigned i = 0; i < c; ++i)
        for (unsigned j = 0; j < c; ++j)
          block[i * target.length[k] + j] += values[(i * c + j) * n_lanes];
    }
}

} // namespace

HEARTBUS_SIMD void insert_rows(const BatchRows &target, const Lanes *K) {
  switch (target.components) {
  case 1:
    return insert<1>(target, K);
  case 3:
    return insert<3>(target, K);
  default:
    return insert<4>(target, K);
  }
}

} // namespace heartbus::fem
