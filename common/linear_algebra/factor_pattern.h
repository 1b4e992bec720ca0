#pragma once

#include "common/linear_algebra/block_pattern.h"

#include <cstddef>
#include <map>
#include <utility>
#include <vector>

namespace heartbus::fem {

/// What an incomplete factorisation without fill knows of matrices before it sees values. The rows are those of the
/// ghosts, from their owners, of which those blocks count whose column is here, too, and then of the owned nodes. In
/// this order a solution needs nothing of the ghosts' rows but their part of L: backwards it ends before them.
class FactorPattern {
 public:
  /// Collective.
  explicit FactorPattern(const BlockPattern &pattern);

  int n_rows() const { return int(begin.size()) - 1; }
  /// The blocks of the ghosts' rows, in the order of their sources, and one number more. Collective.
  std::vector<float> ghost_blocks(const float *values, unsigned components) const;

  int n_ghosts;
  std::vector<int> begin{0}, columns; ///< of each row, sorted; rows, not nodes
  std::vector<int> sources; ///< of each block: its place in the matrix or, in rows of ghosts, in `ghost_blocks`
  std::vector<int> end, factor_columns; ///< of the factors, see BlockFactors

 private:
  void add_owned_rows(const BlockPattern &pattern);
  void add_ghost_rows(const BlockPattern &pattern);
  int row_of(unsigned local_node) const;
  void finish_row(std::vector<std::pair<int, int>> &row);
  void order_factors();

  MPI_Comm communicator_;
  int n_owned_;
  std::map<unsigned, std::vector<int>> sent_; ///< by rank: blocks of owned rows
  std::map<unsigned, std::size_t> received_;  ///< by rank, in their order: how many blocks
};

} // namespace heartbus::fem
