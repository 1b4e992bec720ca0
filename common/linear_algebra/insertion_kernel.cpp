#include "common/linear_algebra/insertion_kernel.h"

#include <cstring>

namespace heartbus::fem {
namespace {

/// Blocks are read once and by all lanes in turn, while they are in the innermost cache.
template <unsigned c, class Number>
HEARTBUS_INLINE void insert(const BatchBlocks<Number> &target, const VectorizedDouble *K) {
  for (unsigned b = 0; b < target.n_nodes; ++b)
    for (unsigned k = 0; k < target.n_used; ++k) {
      Number *block = target.values + long(c * c) * target.position[k][b];
      const double *values = reinterpret_cast<const double *>(K + b * c * c) + target.lane[k];
      for (unsigned j = 0; j < c; ++j)
        for (unsigned i = 0; i < c; ++i)
          block[j * c + i] += Number(values[(i * c + j) * n_lanes]);
    }
}

typedef float Float4 __attribute__((vector_size(16)));
static_assert(n_lanes == 4, "columns are turned into lanes, four by four");

/// Column j of a block of all lanes, turned: entry [lane] holds its four rows.
HEARTBUS_INLINE void column_by_lane(const VectorizedDouble *block, unsigned j, Float4 column[4]) {
  typedef int Order __attribute__((vector_size(16)));
  Float4 row[4];
  for (unsigned i = 0; i < 4; ++i)
    row[i] = __builtin_convertvector(block[4 * i + j], Float4);
  for (unsigned half = 0; half < 2; ++half) { // lanes 0 and 1, 2 and 3
    const int l = 2 * half;
    const Order pairs{l, l + 4, l + 1, l + 5};
    const Float4 upper = __builtin_shuffle(row[0], row[1], pairs), lower = __builtin_shuffle(row[2], row[3], pairs);
    column[l] = __builtin_shuffle(upper, lower, Order{0, 1, 4, 5});
    column[l + 1] = __builtin_shuffle(upper, lower, Order{2, 3, 6, 7});
  }
}

/// The same for 4 x 4 blocks of single precision, a column at once.
template <>
HEARTBUS_INLINE void insert<4, float>(const BatchBlocks<float> &target, const VectorizedDouble *K) {
  for (unsigned b = 0; b < target.n_nodes; ++b)
    for (unsigned j = 0; j < 4; ++j) {
      Float4 column[4];
      column_by_lane(K + 16 * b, j, column);
      for (unsigned k = 0; k < target.n_used; ++k) {
        float *values = target.values + 16l * target.position[k][b] + 4 * j;
        Float4 sum;
        std::memcpy(&sum, values, sizeof sum);
        sum += column[target.lane[k]];
        std::memcpy(values, &sum, sizeof sum);
      }
    }
}

template <class Number>
HEARTBUS_INLINE void insert_all(const BatchBlocks<Number> &target, const VectorizedDouble *K) {
  switch (target.components) {
  case 1:
    return insert<1>(target, K);
  case 3:
    return insert<3>(target, K);
  default:
    return insert<4>(target, K);
  }
}

} // namespace

HEARTBUS_SIMD void insert_blocks(const BatchBlocks<double> &target, const VectorizedDouble *K) {
  insert_all(target, K);
}

HEARTBUS_SIMD void insert_blocks(const BatchBlocks<float> &target, const VectorizedDouble *K) { insert_all(target, K); }

} // namespace heartbus::fem
