#pragma once

#include "common/linear_algebra/linear_solver.h"

#include <memory>

namespace heartbus::fluid {

/// SIMPLE as an approximate block factorisation (Deparis, Grandperrin, Quarteroni 2014,
/// doi:10.1016/j.compfluid.2013.10.034) for the system [F G; B C] (u, p), B = +div here:
///
///     u = F^-1 r_u,   p = S^-1 (r_p - B u),   u = u - D^-1 G p,   S = C - B D^-1 G
///
/// in the variant SIMPLEC, where D holds the row sums of |F|: the diagonal of a consistent mass matrix is 8/27 of its
/// row sum in three dimensions, so SIMPLE's D = diag(F) makes S too stiff. F is dominated by its mass term: a few
/// Chebyshev steps on D^-1 F invert it. S^-1 is one cycle of algebraic multigrid.
class Simplec : public fem::Preconditioner {
 public:
  /// `matrix`: interleaved u, v, w, p at each node; its blocks are copied, so that it may change afterwards.
  /// Collective.
  explicit Simplec(const fem::BlockMatrix<double> &matrix);
  ~Simplec() override;
  void vmult(fem::Vector &y, const fem::Vector &x) const override;

 private:
  struct Blocks;
  std::unique_ptr<Blocks> blocks_;
};

} // namespace heartbus::fluid
