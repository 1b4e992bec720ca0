#pragma once

#include "common/simd/lanes.h"

#include <array>

namespace heartbus::fem {

/// Where the blocks of a batch's cells go: the rows of cell node a of a lane start at row[lane] and lie `length[lane]`
/// numbers apart; the block of cell node b starts at position[lane][b] in each of them. Only the first `n_used` entries
/// count, lane[k] being the lane of entry k.
struct BatchRows {
  unsigned n_nodes, components; ///< 1, 3 or 4
  unsigned n_used = 0;
  std::array<unsigned, n_lanes> lane;
  std::array<double *, n_lanes> row;
  std::array<long, n_lanes> length;
  std::array<const int *, n_lanes> position;
};

/// Adds the blocks K[(b * c + i) * c + j] between one cell node and all cell nodes b.
void insert_rows(const BatchRows &target, const Lanes *K);

/// The same for 4 x 4 blocks of single precision that lie one after the other, each column by column: the blocks of
/// cell node a of a lane start at first[lane], that of cell node b position[lane][b] / 4 blocks later.
struct BatchBlocks {
  unsigned n_nodes, n_used = 0;
  std::array<unsigned, n_lanes> lane;
  std::array<float *, n_lanes> first;
  std::array<const int *, n_lanes> position;
};

void insert_blocks(const BatchBlocks &target, const Lanes *K);

} // namespace heartbus::fem
