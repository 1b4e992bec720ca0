#include "mech_solver/tangent_solver.h"

#include "common/base/failure.h"

#include <algorithm>

namespace heartbus::mech {

std::string TangentSolver::preconditioner_kind() const {
  if (is_static)
    return is_static_stiff_ ? "direct" : "amg";
  return parameters_.preconditioner != "auto" ? parameters_.preconditioner : is_stiff_ ? "amg" : "ilu";
}

unsigned TangentSolver::most_iterations(std::size_t n_rows) const {
  constexpr std::size_t factors_are_large = 100'000; // rows; 27,700 take 1.2 GB
  if (is_static)
    return is_static_stiff_ ? 50 : n_rows < factors_are_large ? 200 : 2000;
  const bool may_change = parameters_.preconditioner == "auto" && !is_stiff_;
  return may_change ? 120 : 500;
}

bool TangentSolver::strengthen() {
  bool &is_stiff = is_static ? is_static_stiff_ : is_stiff_;
  if (is_stiff || (!is_static && parameters_.preconditioner != "auto"))
    return false;
  age_.forget();
  return is_stiff = true;
}

void TangentSolver::follow(const fem::BlockMatrix<double> &tangent) {
  if (preconditioner_)
    preconditioner_->follow(tangent);
}

unsigned TangentSolver::solve(const fem::BlockMatrix<double> &tangent, const fem::BlockMatrix<float> &rounded,
                              fem::Vector &dx, const fem::Vector &force, double tolerance, bus::Stopwatch &stopwatch) {
  const bool renewed = age_.is_due();
  if (renewed) {
    const bus::Stopwatch::Section section(stopwatch, "preconditioner");
    preconditioner_ = fem::make_preconditioner(preconditioner_kind(), tangent);
    age_.renew();
  }
  // Factors cost as much as some twenty solves with them: after half of that new ones are better than to go on.
  const unsigned most = most_iterations(3 * tangent.space().n_global_nodes()),
                 patience = preconditioner_kind() == "direct" ? 10 : 3 * age_.usual() + 50,
                 allowed = renewed ? most : std::min(most, patience);
  try {
    const bus::Stopwatch::Section section(stopwatch, "linear solve");
    const unsigned iterations =
        fem::solve_linear(
            "elasticity", [&](fem::Vector &y, const fem::Vector &x) { rounded.vmult(y, x); }, dx, force,
            *preconditioner_, std::max(parameters_.linear_tolerance, tolerance), allowed)
            .iterations;
    age_.note(iterations);
    return iterations;
  } catch (const Failure &failure) {
    if (failure.code() != ExitCode::not_converged)
      throw;
    age_.forget(); // made for a state too far from this one
    if (renewed && !strengthen())
      throw;
  }
  dx = 0;
  return solve(tangent, rounded, dx, force, tolerance, stopwatch);
}

} // namespace heartbus::mech
