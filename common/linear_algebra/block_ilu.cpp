#include "common/linear_algebra/block_ilu.h"

#include "common/base/failure.h"

#include <algorithm>
#include <cmath>

namespace heartbus::fem {

BlockILU::BlockILU(const BlockMatrix<float> &matrix)
    : components_(matrix.components()), pattern_(matrix.pattern()->factor_pattern()),
      factors_(components_ * components_ * pattern_->columns.size() + 1),
      work_(work_length(components_) * std::size_t(pattern_->n_rows())) {
  const std::vector<float> ghost_blocks = pattern_->ghost_blocks(matrix.values(), components_);
  const RowsWithGhosts rows{pattern_->n_ghosts,       pattern_->begin.data(), pattern_->columns.data(),
                            pattern_->sources.data(), matrix.values(),        ghost_blocks.data()};
  if (factorise_blocks(rows, factors(), factors_.data()))
    return;
  if (!std::all_of(matrix.values(), matrix.values() + matrix.n_entries(), [](float x) { return std::isfinite(x); }))
    throw Failure(ExitCode::not_finite, "the matrix of a linear system is not finite");
  throw Failure(ExitCode::not_converged, "the incomplete factorisation met a zero pivot");
}

void BlockILU::vmult(Vector &y, const Vector &x) const {
  const GhostValues ghosts(x);
  solve_block_ilu(factors(), pattern_->n_ghosts, x.begin(), y.begin(), work_.data());
}

void BlockILU::vmult_3rhs(Vector &y, const Vector &x) const {
  const GhostValues ghosts(x);
  work_.resize(4 * std::size_t(pattern_->n_rows()));
  solve_ilu_3rhs(factors(), pattern_->n_ghosts, x.begin(), y.begin(), work_.data());
}

BlockFactors BlockILU::factors() const {
  return {components_, pattern_->n_rows(), pattern_->end.data(), pattern_->factor_columns.data(), factors_.data()};
}

} // namespace heartbus::fem
