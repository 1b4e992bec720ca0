#include "ale_solver/lifting_problem.h"

#include "ale_solver/jacobian_kernel.h"

#include <limits>

namespace heartbus::ale {

using fem::Vector;
using fem::VectorizedDouble;

namespace {

/// The factorisation, applied to the components that are not prescribed.
class Threefold : public fem::Preconditioner {
 public:
  Threefold(const fem::BlockILU &factorisation, const fem::Constraints &constrained)
      : factorisation_(factorisation), constrained_(constrained) {}
  void vmult(Vector &y, const Vector &x) const override {
    factorisation_.vmult_3rhs(y, x);
    fem::zero_constrained(y, constrained_);
  }

 private:
  const fem::BlockILU &factorisation_;
  const fem::Constraints &constrained_;
};

} // namespace

LiftingProblem::LiftingProblem(const fem::LagrangeSpace &space, const Parameters &parameters)
    : space_(space), tolerance_(parameters.tolerance), laplace_(space, 1), matrix_(laplace_.pattern(), 1) {
  constrain(parameters);
  assemble(laplace_);
  assemble(matrix_);
  factorisation_ = std::make_unique<fem::BlockILU>(matrix_);
}

void LiftingProblem::constrain(const Parameters &parameters) {
  constrained_.assign(3 * space_.n_local_nodes(), 0);
  fem::fix_vector(space_, 3, "interface", constrained_);
  for (const auto &label : parameters.fixed)
    fem::fix_vector(space_, 3, label, constrained_);
  for (const auto &label : parameters.slip)
    fem::fix_normal(space_, 3, label, constrained_);
  fem::Constraints wholly(space_.n_local_nodes());
  for (unsigned node = 0; node < wholly.size(); ++node)
    wholly[node] = constrained_[3 * node] && constrained_[3 * node + 1] && constrained_[3 * node + 2];
  matrix_.set_constraints(wholly);
}

void LiftingProblem::assemble(fem::BlockMatrix<double> &matrix) const {
  const unsigned n = space_.nodes_per_cell();
  std::vector<VectorizedDouble> K(n * n);
  for (unsigned batch = 0; batch < space_.n_batches(); ++batch) {
    std::fill(K.begin(), K.end(), VectorizedDouble{});
    for (unsigned q = 0; q < space_.n_q(); ++q) {
      const VectorizedDouble *gradients = space_.gradients(batch) + q * n * 3;
      for (unsigned a = 0; a < n; ++a)
        for (unsigned b = 0; b < n; ++b)
          for (unsigned i = 0; i < 3; ++i)
            K[a * n + b] += space_.JxW(batch)[q] * gradients[3 * a + i] * gradients[3 * b + i];
    }
    matrix.add_batch(batch, K.data());
  }
}

unsigned LiftingProblem::lift(Vector &ale_displacement) {
  const unsigned iterations = solve(ale_displacement);
  check(ale_displacement);
  return iterations;
}

unsigned LiftingProblem::solve(Vector &ale_displacement) {
  const bus::Stopwatch::Section assembly(stopwatch, "assembly");
  Vector prescribed(ale_displacement), b = space_.make_vector(3), load(b), correction(b);
  for (unsigned k = 0; k < prescribed.locally_owned_size(); ++k)
    if (!constrained_[k])
      prescribed.local_element(k) = 0;
  laplace_.vmult_3rhs(b, ale_displacement);
  b *= -1;
  laplace_.vmult_3rhs(load, prescribed);
  fem::zero_constrained(b, constrained_);
  fem::zero_constrained(load, constrained_);
  const auto [norm, norm_of_load] = fem::norms(b, load);
  const double tolerance = tolerance_ * std::max(1., norm_of_load / norm);
  if (norm == 0 || tolerance >= 1)
    return 0;
  const bus::Stopwatch::Section linear_solve(stopwatch, "linear solve");
  const auto laplace = [&](Vector &y, const Vector &x) {
    matrix_.vmult_3rhs(y, x);
    fem::zero_constrained(y, constrained_);
  };
  const auto statistics =
      fem::solve_linear("lifting", laplace, correction, b, Threefold(*factorisation_, constrained_), tolerance);
  ale_displacement += correction;
  return statistics.iterations;
}

void LiftingProblem::check(const Vector &ale_displacement) {
  const bus::Stopwatch::Section section(stopwatch, "check of the mesh");
  const fem::GhostValues ghosts(ale_displacement);
  const unsigned n = space_.nodes_per_cell();
  std::vector<VectorizedDouble> d(3 * n);
  unsigned worst_slot = 0;
  smallest_J_ = std::numeric_limits<double>::max();
  for (unsigned batch = 0; batch < space_.n_batches(); ++batch) {
    for (unsigned lane = 0; lane < fem::n_lanes; ++lane) {
      const unsigned *nodes = space_.cell_nodes(batch * fem::n_lanes + lane);
      for (unsigned k = 0; k < 3 * n; ++k)
        d[k][lane] = ale_displacement.begin()[3 * nodes[k / 3] + k % 3];
    }
    VectorizedDouble J;
    smallest_jacobian(n, space_.n_q(), space_.gradients(batch), d.data(), J);
    for (unsigned lane = 0; lane < fem::n_lanes; ++lane)
      if (!(J[lane] >= smallest_J_)) {
        smallest_J_ = J[lane];
        worst_slot = batch * fem::n_lanes + lane;
      }
  }
  fem::refuse_inverted_cells(space_, smallest_J_, worst_slot, "the lifted displacement of the wall");
}

} // namespace heartbus::ale
