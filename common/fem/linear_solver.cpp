#include "common/fem/linear_solver.h"

#include "common/bus/failure.h"
#include "common/fem/block_ilu.h"

#include <deal.II/lac/solver_cg.h>
#include <deal.II/lac/solver_control.h>
#include <deal.II/lac/solver_gmres.h>
#include <deal.II/lac/trilinos_precondition.h>

#include <cmath>
#include <sstream>

namespace heartbus::fem {

namespace {

using MultigridData = dealii::TrilinosWrappers::PreconditionAMG::AdditionalData;

class Multigrid : public Preconditioner {
 public:
  Multigrid(const NodalMatrix &matrix, const MultigridData &data) { preconditioner_.initialize(matrix.trilinos(), data); }
  void vmult(Vector &y, const Vector &x) const override { preconditioner_.vmult(y, x); }

 private:
  dealii::TrilinosWrappers::PreconditionAMG preconditioner_;
};

class Jacobi : public Preconditioner {
 public:
  explicit Jacobi(const NodalMatrix &matrix) : inverse_(matrix.space().make_vector(matrix.components())) {
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

std::unique_ptr<Preconditioner> make_amg(const NodalMatrix &matrix) {
  const unsigned c = matrix.components();
  MultigridData data;
  data.elliptic = true;
  data.aggregation_threshold = 1e-4;
  data.smoother_sweeps = 2;
  // The near null space: one constant a component.
  data.constant_modes.assign(c, std::vector<bool>(matrix.n_rows(), false));
  for (int row = 0; row < matrix.n_rows(); ++row)
    data.constant_modes[row % c][row] = true;
  return std::make_unique<Multigrid>(matrix, data);
}

} // namespace

std::unique_ptr<Preconditioner> make_preconditioner(const std::string &kind, const NodalMatrix &matrix) {
  if (kind == "jacobi")
    return std::make_unique<Jacobi>(matrix);
  if (kind == "ilu")
    return std::make_unique<BlockILU>(matrix);
  if (kind == "amg")
    return make_amg(matrix);
  throw Failure(ExitCode::scene, "unknown preconditioner '" + kind + "'; there are jacobi, ilu, amg");
}

namespace {

/// Iterations of conjugate gradients on several ranks before GMRES takes over.
constexpr unsigned patience = 60;

struct OperatorMatrix {
  const Operator &apply;
  void vmult(Vector &y, const Vector &x) const { apply(y, x); }
};

/// Conjugate gradients, flexible because the factorisation is not symmetric on several ranks. Where mass does not dominate
/// (large steps on fine meshes) that can make them stagnate: returns whether they have converged.
template <class Matrix>
bool conjugate_gradients(const Matrix &A, Vector &x, const Vector &b, const Preconditioner &preconditioner,
                         LinearStatistics &statistics, double wanted, unsigned max_iterations) {
  dealii::SolverControl control(max_iterations, wanted);
  try {
    dealii::SolverFlexibleCG<Vector>(control).solve(A, x, b, preconditioner);
  } catch (const dealii::SolverControl::NoConvergence &) {
    if (!std::isfinite(control.last_value()))
      x = 0;
  }
  statistics = {control.last_step(), control.initial_value(), control.last_value()};
  return control.last_check() == dealii::SolverControl::success;
}

template <class Matrix>
LinearStatistics solve(const std::string &what, const std::string &method, const Matrix &A, Vector &x, const Vector &b,
                       const Preconditioner &preconditioner, double tolerance, unsigned max_iterations) {
  const double norm = b.l2_norm();
  if (!std::isfinite(norm))
    throw Failure(ExitCode::not_finite, what + ": the right-hand side is not finite");
  if (norm == 0) {
    x = 0;
    return {};
  }
  LinearStatistics statistics;
  const bool alone = dealii::Utilities::MPI::n_mpi_processes(b.get_mpi_communicator()) == 1;
  if (method == "cg" && conjugate_gradients(A, x, b, preconditioner, statistics, tolerance * norm,
                                            alone ? max_iterations : std::min(patience, max_iterations)))
    return statistics;
  dealii::SolverControl control(max_iterations, tolerance * norm);
  try {
    // Right preconditioning: the residual that is tested is the true one.
    dealii::SolverGMRES<Vector>(control, dealii::SolverGMRES<Vector>::AdditionalData(80, true))
        .solve(A, x, b, preconditioner);
  } catch (const dealii::SolverControl::NoConvergence &e) {
    std::ostringstream message;
    message << what << ": " << method << " stopped after " << statistics.iterations + e.last_step << " iterations at a residual of "
            << e.last_residual / norm << " of the right-hand side, wanted " << tolerance;
    throw Failure(std::isfinite(e.last_residual) ? ExitCode::not_converged : ExitCode::not_finite, message.str());
  }
  return {statistics.iterations + control.last_step(), control.initial_value(), control.last_value()};
}

} // namespace

LinearStatistics solve_linear(const std::string &what, const std::string &method, const NodalMatrix &A, Vector &x,
                              const Vector &b, const Preconditioner &preconditioner, double tolerance,
                              unsigned max_iterations) {
  return solve(what, method, A, x, b, preconditioner, tolerance, max_iterations);
}

LinearStatistics solve_linear(const std::string &what, const std::string &method, const Operator &A, Vector &x,
                              const Vector &b, const Preconditioner &preconditioner, double tolerance,
                              unsigned max_iterations) {
  return solve(what, method, OperatorMatrix{A}, x, b, preconditioner, tolerance, max_iterations);
}

} // namespace heartbus::fem
