#include "ale_solver/lifting_problem.h"

#include "common/fem/small_matrix.h"

#include <limits>

namespace heartbus::ale {

using fem::Lanes;
using fem::Vector;

LiftingProblem::LiftingProblem(const fem::LagrangeSpace &space, const Parameters &parameters)
    : space_(space), tolerance_(parameters.tolerance), laplace_(space, 1) {
  assemble(laplace_);
  const auto of_components = constraints(parameters);
  for (unsigned i = 0; i < 3; ++i) {
    unsigned s = 0;
    while (s < systems_.size() &&
           dealii::Utilities::MPI::max(int(systems_[s].constrained != of_components[i]), space.communicator()))
      ++s;
    of_component_[i] = s;
    if (s < systems_.size())
      continue;
    System system{of_components[i], std::make_unique<fem::NodalMatrix>(space, 1), nullptr};
    system.matrix->set_constraints(system.constrained);
    assemble(*system.matrix);
    system.preconditioner = fem::make_preconditioner("ilu", *system.matrix);
    systems_.push_back(std::move(system));
  }
}

std::array<fem::Constraints, 3> LiftingProblem::constraints(const Parameters &parameters) const {
  fem::Constraints vector(3 * space_.n_local_nodes());
  fem::fix_vector(space_, 3, "interface", vector);
  for (const auto &label : parameters.fixed)
    fem::fix_vector(space_, 3, label, vector);
  for (const auto &label : parameters.slip)
    fem::fix_normal(space_, 3, label, vector);
  std::array<fem::Constraints, 3> components;
  for (std::size_t k = 0; k < vector.size(); ++k)
    components[k % 3].push_back(vector[k]);
  return components;
}

void LiftingProblem::assemble(fem::NodalMatrix &matrix) const {
  const unsigned n = space_.nodes_per_cell();
  std::vector<Lanes> K(n * n);
  for (unsigned batch = 0; batch < space_.n_batches(); ++batch) {
    std::fill(K.begin(), K.end(), Lanes{});
    for (unsigned q = 0; q < space_.n_q(); ++q) {
      const Lanes *gradients = space_.gradients(batch) + q * n * 3;
      for (unsigned a = 0; a < n; ++a)
        for (unsigned b = 0; b < n; ++b)
          for (unsigned i = 0; i < 3; ++i)
            K[a * n + b] += space_.JxW(batch)[q] * gradients[3 * a + i] * gradients[3 * b + i];
    }
    matrix.add_batch(batch, K.data());
  }
}

unsigned LiftingProblem::lift(Vector &motion) {
  unsigned iterations = 0;
  for (unsigned i = 0; i < 3; ++i)
    iterations += lift_component(motion, i);
  motion.update_ghost_values();
  check(motion);
  return iterations;
}

unsigned LiftingProblem::lift_component(Vector &motion, unsigned i) {
  const bus::Stopwatch::Section assembly(stopwatch, "assembly");
  const System &system = systems_[of_component_[i]];
  Vector d = space_.make_vector(1), prescribed = d, b = d, load = d, correction = d;
  for (unsigned node = 0; node < space_.n_owned_nodes(); ++node) {
    d.local_element(node) = motion.local_element(3 * node + i);
    if (system.constrained[node])
      prescribed.local_element(node) = d.local_element(node);
  }
  laplace_.vmult(b, d);
  b *= -1;
  laplace_.vmult(load, prescribed);
  fem::zero_constrained(b, system.constrained);
  fem::zero_constrained(load, system.constrained);
  const double norm = b.l2_norm(), tolerance = tolerance_ * std::max(1., load.l2_norm() / norm);
  if (norm == 0 || tolerance >= 1)
    return 0;
  const bus::Stopwatch::Section linear_solve(stopwatch, "linear solve");
  const auto statistics =
      fem::solve_linear("lifting", "cg", *system.matrix, correction, b, *system.preconditioner, tolerance);
  for (unsigned node = 0; node < space_.n_owned_nodes(); ++node)
    motion.local_element(3 * node + i) += correction.local_element(node);
  return statistics.iterations;
}

void LiftingProblem::check(const Vector &motion) {
  const bus::Stopwatch::Section section(stopwatch, "check of the mesh");
  const unsigned n = space_.nodes_per_cell();
  unsigned worst_slot = 0;
  smallest_J_ = std::numeric_limits<double>::max();
  for (unsigned batch = 0; batch < space_.n_batches(); ++batch)
    for (unsigned q = 0; q < space_.n_q(); ++q) {
      fem::Mat3<Lanes> F = fem::identity<Lanes>();
      for (unsigned a = 0; a < n; ++a)
        for (unsigned i = 0; i < 3; ++i) {
          Lanes d;
          for (unsigned lane = 0; lane < fem::n_lanes; ++lane)
            d[lane] = motion.begin()[3 * space_.cell_nodes(batch * fem::n_lanes + lane)[a] + i];
          for (unsigned j = 0; j < 3; ++j)
            F[i][j] += d * space_.gradients(batch)[(q * n + a) * 3 + j];
        }
      const Lanes J = fem::determinant(F);
      for (unsigned lane = 0; lane < fem::n_lanes; ++lane)
        if (!(J[lane] >= smallest_J_)) {
          smallest_J_ = J[lane];
          worst_slot = batch * fem::n_lanes + lane;
        }
    }
  fem::refuse_inverted_cells(space_, smallest_J_, worst_slot, "the lifted displacement of the wall");
}

} // namespace heartbus::ale
