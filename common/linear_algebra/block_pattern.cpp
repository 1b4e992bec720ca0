#include "common/linear_algebra/block_pattern.h"

#include "common/linear_algebra/factor_pattern.h"

#include <algorithm>

namespace heartbus::fem {

BlockPattern::BlockPattern(const LagrangeSpace &space) : space_(space) {
  const unsigned n = space.nodes_per_cell(), n_owned = space.n_owned_nodes();
  std::vector<std::vector<int>> neighbours(n_owned);
  for (unsigned slot = 0; slot < space.n_slots(); ++slot)
    for (unsigned a = 0; a < n; ++a)
      if (const unsigned node = space.cell_nodes(slot)[a]; node < n_owned)
        neighbours[node].insert(neighbours[node].end(), space.cell_nodes(slot), space.cell_nodes(slot) + n);
  for (auto &row : neighbours) {
    std::sort(row.begin(), row.end());
    columns_.insert(columns_.end(), row.begin(), std::unique(row.begin(), row.end()));
    begin_.push_back(int(columns_.size()));
  }
  positions_.reserve(std::size_t(space.n_slots()) * n * n);
  for (unsigned slot = 0; slot < space.n_slots(); ++slot)
    for (unsigned a = 0; a < n; ++a)
      for (unsigned b = 0; b < n; ++b)
        positions_.push_back(find(space.cell_nodes(slot)[a], space.cell_nodes(slot)[b]));
}

int BlockPattern::find(unsigned row, unsigned column) const {
  if (int(row) >= n_rows())
    return -1;
  const auto first = columns_.begin() + begin_[row], last = columns_.begin() + begin_[row + 1];
  const auto found = std::lower_bound(first, last, int(column));
  return found != last && *found == int(column) ? int(found - columns_.begin()) : -1;
}

std::shared_ptr<const FactorPattern> BlockPattern::factor_pattern() const {
  if (!factor_pattern_)
    factor_pattern_ = std::make_shared<const FactorPattern>(*this);
  return factor_pattern_;
}

} // namespace heartbus::fem
