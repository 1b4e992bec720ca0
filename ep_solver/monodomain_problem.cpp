#include "ep_solver/monodomain_problem.h"

namespace heartbus::ep {

using fem::Lanes;

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
  preconditioner_ = fem::make_preconditioner(preconditioner_kind_, A_);
}

fem::LinearStatistics MonodomainProblem::solve(const fem::Vector &v_n, const fem::Vector &I, fem::Vector &v) {
  const bus::Stopwatch::Section assembly(stopwatch, "assembly");
  rate_ = I;
  rate_.add(1 / dt_, v_n);
  M_.vmult(rhs_, rate_);
  const double scale = rhs_.l2_norm();
  A_.vmult(work_, v);
  rhs_ -= work_;
  const double residual = rhs_.l2_norm();
  if (residual <= tolerance_ * scale)
    return {0, residual, residual};
  const bus::Stopwatch::Section linear_solve(stopwatch, "linear solve");
  increment_ = 0;
  const auto statistics = fem::solve_linear("monodomain equation", "cg", A_, increment_, rhs_, *preconditioner_,
                                            tolerance_ * scale / residual);
  v += increment_;
  return statistics;
}

} // namespace heartbus::ep
