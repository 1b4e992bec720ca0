#include "ep_solver/monodomain_problem.h"

namespace heartbus::ep {

using fem::Lanes;

namespace {

/// A correction by the rounded matrix leaves about 1e-7 of the residual.
constexpr double what_rounding_allows = 1e-6;

} // namespace

MonodomainProblem::MonodomainProblem(const fem::LagrangeSpace &space, const std::vector<fem::Mat3<Lanes>> &D,
                                     double tolerance, const std::string &preconditioner)
    : M_(space, 1), K_(space, 1), A_(space, 1), tolerance_(tolerance), preconditioner_kind_(preconditioner),
      rate_(space.make_vector(1)), rhs_(space.make_vector(1)), work_(space.make_vector(1)),
      increment_(space.make_vector(1)) {
  const unsigned n = space.nodes_per_cell(), n_q = space.n_q();
  std::vector<Lanes> M(n * n), K(n * n);
  for (unsigned batch = 0; batch < space.n_batches(); ++batch) {
    monodomain_matrices(n_q, n, space.shapes(), space.gradients(batch), space.JxW(batch), &D[batch * n_q], M.data(),
                        K.data());
    M_.add_batch(batch, M.data());
    K_.add_batch(batch, K.data());
  }
}

void MonodomainProblem::set_step(double dt) {
  if (dt == dt_)
    return;
  const bus::Stopwatch::Section section(stopwatch, "preconditioner");
  dt_ = dt;
  A_.copy_scaled(1 / dt, M_);
  A_.add_scaled(1, K_);
  rounded_A_ = std::make_unique<fem::RoundedMatrix>(A_);
  preconditioner_ = fem::make_preconditioner(preconditioner_kind_, A_);
}

fem::LinearStatistics MonodomainProblem::solve(const fem::Vector &v_n, const fem::Vector &I, fem::Vector &v) {
  const bus::Stopwatch::Section assembly(stopwatch, "assembly");
  rate_ = I;
  rate_.add(1 / dt_, v_n);
  M_.vmult(rhs_, rate_);
  const double wanted = tolerance_ * rhs_.l2_norm();
  fem::LinearStatistics statistics;
  statistics.residual = statistics.initial_residual = subtract_product(v);
  while (statistics.residual > wanted) {
    const double reduction = wanted / statistics.residual;
    const auto correction = correct(v, std::max(reduction, what_rounding_allows));
    statistics.iterations += correction.iterations;
    statistics.residual = correction.residual;
    if (reduction >= what_rounding_allows)
      break;
    M_.vmult(rhs_, rate_);
    statistics.residual = subtract_product(v);
  }
  return statistics;
}

/// rhs -= A v; returns its norm.
double MonodomainProblem::subtract_product(const fem::Vector &v) {
  A_.vmult(work_, v);
  rhs_ -= work_;
  return rhs_.l2_norm();
}

fem::LinearStatistics MonodomainProblem::correct(fem::Vector &v, double reduction) {
  const bus::Stopwatch::Section linear_solve(stopwatch, "linear solve");
  increment_ = 0;
  const auto statistics = fem::solve_linear(
      "monodomain equation", "cg", [this](fem::Vector &y, const fem::Vector &x) { rounded_A_->vmult(y, x); }, increment_,
      rhs_, *preconditioner_, reduction);
  v += increment_;
  return statistics;
}

} // namespace heartbus::ep
