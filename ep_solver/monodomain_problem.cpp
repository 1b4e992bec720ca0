#include "ep_solver/monodomain_problem.h"

#include "common/base/failure.h"

#include <cmath>

namespace heartbus::ep {

using fem::VectorizedDouble;

namespace {

/// A correction by the rounded matrix leaves about 1e-7 of the residual.
constexpr double what_rounding_allows = 1e-6;

} // namespace

MonodomainProblem::MonodomainProblem(const fem::LagrangeSpace &space, const std::vector<fem::Mat3<VectorizedDouble>> &D,
                                     double tolerance, const std::string &preconditioner)
    : M_(space, 1), K_(M_.pattern(), 1), A_(M_.pattern(), 1), wv_(2 * std::size_t(space.n_local_nodes())),
      weights_(space.make_vector(1)), tolerance_(tolerance), preconditioner_kind_(preconditioner), rate_(weights_),
      residual_(weights_), increment_(weights_) {
  const unsigned n = space.nodes_per_cell(), n_q = space.n_q();
  std::vector<VectorizedDouble> M(n * n), K(n * n);
  for (unsigned batch = 0; batch < space.n_batches(); ++batch) {
    monodomain_matrices(n_q, n, space.shapes(), space.gradients(batch), space.JxW(batch), &D[batch * n_q], M.data(),
                        K.data());
    M_.add_batch(batch, M.data());
    K_.add_batch(batch, K.data());
  }
  const fem::BlockPattern &pattern = *M_.pattern();
  entries_.reserve(2 * M_.n_entries());
  for (int row = 0; row < pattern.n_rows(); ++row)
    for (int k = pattern.begin()[row]; k < pattern.begin()[row + 1]; ++k) {
      entries_.insert(entries_.end(), {float(M_.values()[k]), float(-K_.values()[k])});
      weights_.local_element(row) += M_.values()[k];
    }
}

void MonodomainProblem::set_step(double dt) {
  if (dt == dt_)
    return;
  dt_ = dt;
  for (current_ = 0; current_ < operators_.size(); ++current_)
    if (operators_[current_].dt == dt)
      return;
  const bus::Stopwatch::Section section(stopwatch, "preconditioner");
  A_.copy_scaled(1 / dt, M_);
  A_.add_scaled(1, K_);
  operators_.push_back({dt, fem::BlockMatrix<float>(A_), fem::make_preconditioner(preconditioner_kind_, A_)});
}

fem::LinearStatistics MonodomainProblem::solve(const fem::Vector &v_n, const fem::Vector &I, fem::Vector &v) {
  const bus::Stopwatch::Section assembly(stopwatch, "assembly");
  rate_ = I;
  rate_.add(1 / dt_, v_n);
  residual_ = rate_;
  residual_.scale(weights_);
  const double own_load = fem::own_square(residual_);
  find_residual(v);
  std::vector<double> squares{own_load, fem::own_square(residual_)};
  dealii::Utilities::MPI::sum(squares, v.get_mpi_communicator(), squares);
  const double wanted = tolerance_ * std::sqrt(squares[0]);
  fem::LinearStatistics statistics;
  statistics.residual = statistics.initial_residual = std::sqrt(squares[1]);
  if (!std::isfinite(statistics.residual) || !std::isfinite(wanted))
    throw Failure(ExitCode::not_finite, "monodomain equation: the potential or the ionic current is not finite");
  while (statistics.residual > wanted) {
    const double reduction = wanted / statistics.residual;
    const auto correction = correct(v, std::max(reduction, what_rounding_allows));
    statistics.iterations += correction.iterations;
    statistics.residual = correction.residual;
    if (reduction >= what_rounding_allows)
      break;
    find_residual(v);
    statistics.residual = residual_.l2_norm();
  }
  return statistics;
}

void MonodomainProblem::find_residual(const fem::Vector &v) {
  const fem::GhostValues ghosts(v), ghosts_of_rate(rate_);
  for (std::size_t node = 0; node < wv_.size() / 2; ++node) {
    wv_[2 * node] = rate_.begin()[node] - v.begin()[node] / dt_;
    wv_[2 * node + 1] = v.begin()[node];
  }
  const fem::BlockPattern &pattern = *M_.pattern();
  subtract_flux(pattern.n_rows(), pattern.begin(), pattern.columns(), entries_.data(), wv_.data(), residual_.begin());
}

fem::LinearStatistics MonodomainProblem::correct(fem::Vector &v, double reduction) {
  const bus::Stopwatch::Section linear_solve(stopwatch, "linear solve");
  increment_ = 0;
  const Operator &A = operators_[current_];
  const auto statistics = fem::solve_linear(
      "monodomain equation", [&A](fem::Vector &y, const fem::Vector &x) { A.matrix.vmult(y, x); }, increment_,
      residual_, *A.preconditioner, reduction);
  v += increment_;
  return statistics;
}

} // namespace heartbus::ep
