#pragma once

#include "common/linear_algebra/block_matrix.h"

#include <functional>
#include <memory>
#include <string>
#include <utility>

namespace heartbus::fem {

/// Of the entries that this rank owns. Where several norms are needed at once, one sum over the ranks can do.
double own_square(const Vector &x);
/// Their l2 norms by one sum over the ranks. Collective.
std::pair<double, double> norms(const Vector &x, const Vector &y);

/// How a linear solve went.
struct LinearStatistics {
  unsigned iterations = 0;
  double initial_residual = 0, residual = 0; ///< l2 norms of b - A x
};

/// Anything that approximates the inverse of a matrix.
class Preconditioner {
 public:
  virtual ~Preconditioner() = default;
  virtual void vmult(Vector &y, const Vector &x) const = 0;
  /// The matrix has changed: what works on the matrix itself takes its new values, the rest stays.
  virtual void follow(const BlockMatrix<double> &) {}
};

/// "jacobi", "ilu" (see BlockILU), "amg" (ML smoothed aggregation; `elliptic`, near null space of `components`
/// constants), "direct" (see make_direct_solver). Collective; keeps what it needs of the matrix, so the matrix may
/// change afterwards.
std::unique_ptr<Preconditioner> make_preconditioner(const std::string &kind, const BlockMatrix<double> &matrix);

/// Solves A x = b to |b - A x| <= tolerance * |b| by GMRES, starting from x. Zero b gives zero x.
/// Throws Failure(not_converged) naming `what`, the iterations and the residual reached; Failure(not_finite) on NaN.
LinearStatistics solve_linear(const std::string &what, const BlockMatrix<double> &A, Vector &x, const Vector &b,
                              const Preconditioner &preconditioner, double tolerance, unsigned max_iterations = 500);

/// The same for an operator y = A x that is not a matrix, e.g. a matrix plus a dense term of low rank.
using Operator = std::function<void(Vector &y, const Vector &x)>;
LinearStatistics solve_linear(const std::string &what, const Operator &A, Vector &x, const Vector &b,
                              const Preconditioner &preconditioner, double tolerance, unsigned max_iterations = 500);

} // namespace heartbus::fem
