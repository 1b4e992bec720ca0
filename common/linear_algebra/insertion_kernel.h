#pragma once

#include "common/simd/vectorized_double.h"

#include <array>

namespace heartbus::fem {

/// Where the blocks of a batch's cells go, which lie one after the other in `values`, each column by column: in the
/// row of one cell node of lane[k], the block of cell node b is number position[k][b]. Only the first `n_used`
/// entries count.
template <class Number>
struct BatchBlocks {
  unsigned n_nodes, components; ///< 1, 3 or 4
  Number *values;
  unsigned n_used = 0;
  std::array<unsigned, n_lanes> lane;
  std::array<const int *, n_lanes> position;
};

/// Adds the blocks K[(b * c + i) * c + j] between one cell node and all cell nodes b.
void insert_blocks(const BatchBlocks<double> &target, const VectorizedDouble *K);
void insert_blocks(const BatchBlocks<float> &target, const VectorizedDouble *K);

} // namespace heartbus::fem
