#pragma once

#include "common/linear_algebra/block_ilu_kernel.h"
#include "common/linear_algebra/block_matrix.h"
#include "common/linear_algebra/factor_pattern.h"
#include "common/linear_algebra/linear_solver.h"

#include <vector>

namespace heartbus::fem {

/// Incomplete LU factorisation without fill of the dense blocks between nodes, of 1, 3 or 4 components. Each rank
/// factorises the rows of its own nodes and of its ghosts, and keeps of the solution what belongs to its own nodes:
/// restricted additive Schwarz with an overlap of one layer (X.-C. Cai, M. Sarkis, doi:10.1137/S106482759732678X). The
/// blocks of a node are inverted exactly, which takes care of the coupling of its components; at the time steps of a
/// heartbeat, where mass dominates, that is nearly all there is. Factors are held in single precision: they are an
/// approximation anyway, and the solver is bound by memory traffic. They are made and applied in double precision. On
/// several ranks the approximate inverse of a symmetric matrix is not quite symmetric, hence GMRES there, too.
class BlockILU : public Preconditioner {
 public:
  /// Collective. The matrix may change afterwards. Failure(not_converged) when a pivot vanishes.
  explicit BlockILU(const BlockMatrix<float> &matrix);
  explicit BlockILU(const BlockMatrix<double> &matrix) : BlockILU(BlockMatrix<float>(matrix)) {}
  void vmult(Vector &y, const Vector &x) const override;
  /// The same for each of three components of x, by the factors of a matrix of one component.
  void vmult_3rhs(Vector &y, const Vector &x) const;

 private:
  BlockFactors factors() const;

  unsigned components_;
  std::shared_ptr<const FactorPattern> pattern_;
  std::vector<float> factors_;
  mutable std::vector<double> work_;
};

} // namespace heartbus::fem
