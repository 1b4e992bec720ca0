#include "mech_solver/tangent_solver.h"

#include "common/base/failure.h"

#include <algorithm>

namespace heartbus::mech {

std::string TangentSolver::preconditioner_kind() const {
  if (is_static)
    return "amg";
  return parameters_.preconditioner != "auto" ? parameters_.preconditioner : is_stiff_ ? "amg" : "ilu";
}

unsigned TangentSolver::most_iterations() const {
  const bool may_change = !is_static && parameters_.preconditioner == "auto" && !is_stiff_;
  return may_change ? 120 : is_static ? 2000 : 500;
}

bool TangentSolver::go_over_to_multigrid() {
  if (is_static || parameters_.preconditioner != "auto" || is_stiff_)
    return false;
  return is_old_ = is_stiff_ = true;
}

void TangentSolver::follow(const fem::BlockMatrix<double> &tangent) {
  if (preconditioner_)
    preconditioner_->follow(tangent);
}

unsigned TangentSolver::solve(const fem::BlockMatrix<double> &tangent, const fem::BlockMatrix<float> &rounded,
                              fem::Vector &dx, const fem::Vector &force, double tolerance,
                              bus::Stopwatch &stopwatch) {
  const bool renewed = is_old_;
  if (renewed) {
    const bus::Stopwatch::Section section(stopwatch, "preconditioner");
    preconditioner_ = fem::make_preconditioner(preconditioner_kind(), tangent);
  }
  const unsigned allowed = renewed ? most_iterations() : std::min(most_iterations(), 3 * usual_iterations_ + 50);
  try {
    const bus::Stopwatch::Section section(stopwatch, "linear solve");
    const unsigned iterations =
        fem::solve_linear(
            "elasticity", [&](fem::Vector &y, const fem::Vector &x) { rounded.vmult(y, x); }, dx, force,
            *preconditioner_, std::max(parameters_.linear_tolerance, tolerance), allowed)
            .iterations;
    if (renewed)
      usual_iterations_ = iterations;
    is_old_ = iterations > usual_iterations_ + usual_iterations_ / 2 + 3;
    return iterations;
  } catch (const Failure &failure) {
    if (failure.code() != ExitCode::not_converged)
      throw;
    if (!renewed) // a state too far from the one that it was made for
      is_old_ = true;
    else if (!go_over_to_multigrid())
      throw;
  }
  dx = 0;
  return solve(tangent, rounded, dx, force, tolerance, stopwatch);
}

} // namespace heartbus::mech
