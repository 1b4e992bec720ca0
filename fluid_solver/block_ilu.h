#pragma once

#include "common/fem/linear_solver.h"
#include "fluid_solver/block_ilu_kernel.h"

#include <vector>

namespace heartbus::fluid {

/// Incomplete LU factorisation without fill of the 4x4 blocks (u, v, w, p) between nodes, each rank its own part (block
/// Jacobi over ranks). The blocks of a node are inverted exactly, which takes care of the coupling of pressure and velocity
/// in a point; at the time steps of a heartbeat, where mass dominates, that is nearly all there is. Factors are held in
/// single precision: they are an approximation anyway, and the solver is bound by memory traffic. They are applied in
/// double precision, because GMRES converges only as far as its preconditioner is linear.
class BlockILU : public fem::Preconditioner {
 public:
  /// The matrix may change afterwards.
  explicit BlockILU(const fem::NodalMatrix &matrix);
  void vmult(fem::Vector &y, const fem::Vector &x) const override;

 private:
  using Block = std::array<double, 16>; ///< row by row
  void copy_pattern(const fem::NodalMatrix &matrix);
  std::vector<Block> factorise(const fem::NodalMatrix &matrix) const;
  void store(const std::vector<Block> &factors);

  std::vector<int> begin_, diagonal_, columns_; ///< see BlockFactors
  std::vector<float> factors_;
};

} // namespace heartbus::fluid
