#pragma once

#include "common/fem/lagrange_space.h"

#include <memory>
#include <vector>

namespace heartbus::fem {

class FactorPattern;

/// Which nodes of a space are neighbours: the places of the blocks of its matrices, however many components they have.
/// Rows are those of the owned nodes; they are complete, because each rank also visits the ghost cells that touch its
/// nodes. The blocks of a row are sorted by the local node of their column.
class BlockPattern {
 public:
  explicit BlockPattern(const LagrangeSpace &space);

  const LagrangeSpace &space() const { return space_; }
  int n_rows() const { return int(begin_.size()) - 1; }
  int n_blocks() const { return begin_.back(); }
  const int *begin() const { return begin_.data(); }     ///< [row], and the end: numbers of blocks
  const int *columns() const { return columns_.data(); } ///< [block] local node
  /// [b]: the block between cell nodes a and b of a slot; all of them are -1 where a is not owned.
  const int *positions(unsigned slot, unsigned a) const {
    return &positions_[(std::size_t(slot) * space_.nodes_per_cell() + a) * space_.nodes_per_cell()];
  }
  /// The block between an owned and a local node; -1 when they are no neighbours.
  int find(unsigned row, unsigned column) const;
  /// Of incomplete factorisations; made when asked for the first time, which is collective.
  std::shared_ptr<const FactorPattern> factor_pattern() const;

 private:
  const LagrangeSpace &space_;
  std::vector<int> begin_{0}, columns_, positions_;
  mutable std::shared_ptr<const FactorPattern> factor_pattern_;
};

} // namespace heartbus::fem
