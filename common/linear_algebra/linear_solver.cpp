#include "common/linear_algebra/linear_solver.h"

#include "common/base/failure.h"
#include "common/linear_algebra/block_ilu.h"
#include "common/linear_algebra/direct_solver.h"
#include "common/linear_algebra/flexible_gmres.h"
#include "common/linear_algebra/trilinos_copy.h"

#include <deal.II/lac/trilinos_precondition.h>

#include <cmath>
#include <sstream>

namespace heartbus::fem {

namespace {

using MultigridData = dealii::TrilinosWrappers::PreconditionAMG::AdditionalData;

class Multigrid : public Preconditioner {
 public:
  Multigrid(const BlockMatrix<double> &matrix, const MultigridData &data) : finest_(trilinos_copy(matrix)) {
    preconditioner_.initialize(*finest_, data);
  }
  void vmult(Vector &y, const Vector &x) const override { preconditioner_.vmult(y, x); }
  void follow(const BlockMatrix<double> &matrix) override { copy_values(matrix, *finest_); }

 private:
  std::unique_ptr<Epetra_CrsMatrix> finest_; ///< on which it smooths
  dealii::TrilinosWrappers::PreconditionAMG preconditioner_;
};

class Jacobi : public Preconditioner {
 public:
  explicit Jacobi(const BlockMatrix<double> &matrix) : inverse_(matrix.space().make_vector(matrix.components())) {
    matrix.diagonal(inverse_);
    for (unsigned i = 0; i < inverse_.locally_owned_size(); ++i)
      inverse_.local_element(i) = 1.0 / inverse_.local_element(i);
  }
  void vmult(Vector &y, const Vector &x) const override {
    for (unsigned i = 0; i < inverse_.locally_owned_size(); ++i)
      y.local_element(i) = inverse_.local_element(i) * x.local_element(i);
  }

 private:
  Vector inverse_;
};

std::unique_ptr<Preconditioner> make_amg(const BlockMatrix<double> &matrix) {
  const unsigned c = matrix.components();
  MultigridData data;
  data.elliptic = true;
  data.aggregation_threshold = 1e-4;
  data.smoother_sweeps = 2;
  // The near null space: one constant a component.
  data.constant_modes.assign(c, std::vector<bool>(matrix.n_rows(), false));
  for (std::size_t row = 0; row < matrix.n_rows(); ++row)
    data.constant_modes[row % c][row] = true;
  return std::make_unique<Multigrid>(matrix, data);
}

} // namespace

std::unique_ptr<Preconditioner> make_preconditioner(const std::string &kind, const BlockMatrix<double> &matrix) {
  if (kind == "jacobi")
    return std::make_unique<Jacobi>(matrix);
  if (kind == "ilu")
    return std::make_unique<BlockILU>(matrix);
  if (kind == "amg")
    return make_amg(matrix);
  if (kind == "direct")
    return make_direct_solver(matrix);
  throw Failure(ExitCode::scene, "unknown preconditioner '" + kind + "'; there are jacobi, ilu, amg, direct");
}

namespace {

struct OperatorMatrix {
  const Operator &apply;
  void vmult(Vector &y, const Vector &x) const { apply(y, x); }
};

template <class Matrix>
double find_residual(const Matrix &A, const Vector &x, const Vector &b, Vector &r) {
  A.vmult(r, x);
  r.sadd(-1, 1, b);
  return r.l2_norm();
}

template <class Matrix>
LinearStatistics solve(const std::string &what, const Matrix &A, Vector &x, const Vector &b,
                       const Preconditioner &preconditioner, double tolerance, unsigned max_iterations) {
  constexpr unsigned restart = 80;
  const auto [norm, start] = norms(b, x);
  if (!std::isfinite(norm))
    throw Failure(ExitCode::not_finite, what + ": the right-hand side is not finite");
  if (norm == 0) {
    x = 0;
    return {};
  }
  Vector r(b);
  LinearStatistics statistics;
  statistics.initial_residual = statistics.residual = start == 0 ? norm : find_residual(A, x, b, r);
  FlexibleGMRES<Matrix> gmres(A, preconditioner, b);
  const double wanted = tolerance * norm;
  while (statistics.residual > wanted && gmres.n_iterations < max_iterations) {
    if (gmres.n_iterations > 0)
      statistics.residual = find_residual(A, x, b, r);
    statistics.residual =
        gmres.improve(x, r, statistics.residual, wanted, std::min(restart, max_iterations - gmres.n_iterations));
  }
  statistics.iterations = gmres.n_iterations;
  if (statistics.residual <= wanted)
    return statistics;
  std::ostringstream message;
  message << what << ": GMRES stopped after " << statistics.iterations << " iterations at a residual of "
          << statistics.residual / norm << " of the right-hand side, wanted " << tolerance;
  throw Failure(std::isfinite(statistics.residual) ? ExitCode::not_converged : ExitCode::not_finite, message.str());
}

} // namespace

double own_square(const Vector &x) {
  std::vector<double> square;
  multiply_by_basis(x.locally_owned_size(), {}, x.begin(), square);
  return square[0];
}

std::pair<double, double> norms(const Vector &x, const Vector &y) {
  std::vector<double> squares{own_square(x), own_square(y)};
  dealii::Utilities::MPI::sum(squares, x.get_mpi_communicator(), squares);
  return {std::sqrt(squares[0]), std::sqrt(squares[1])};
}

LinearStatistics solve_linear(const std::string &what, const BlockMatrix<double> &A, Vector &x, const Vector &b,
                              const Preconditioner &preconditioner, double tolerance, unsigned max_iterations) {
  return solve(what, A, x, b, preconditioner, tolerance, max_iterations);
}

LinearStatistics solve_linear(const std::string &what, const Operator &A, Vector &x, const Vector &b,
                              const Preconditioner &preconditioner, double tolerance, unsigned max_iterations) {
  return solve(what, OperatorMatrix{A}, x, b, preconditioner, tolerance, max_iterations);
}

} // namespace heartbus::fem
