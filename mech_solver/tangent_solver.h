#pragma once

#include "common/base/stopwatch.h"
#include "common/linear_algebra/linear_solver.h"
#include "common/linear_algebra/preconditioner_age.h"
#include "mech_solver/settings/parameters.h"

#include <memory>
#include <string>

namespace heartbus::mech {

/// Solves with the wall's tangent, and knows its preconditioner: kept for as long as it serves about as well as when it
/// was new. Dynamic systems are dominated by the mass; static ones are not well conditioned and need multigrid. So do
/// dynamic ones of walls that hardly change their volume (kappa above some 100 kPa on fine meshes). Static ones of such
/// walls are beyond multigrid and are factorised.
class TangentSolver {
 public:
  explicit TangentSolver(const SolverParameters &parameters) : parameters_(parameters) {}

  bool is_static = true; ///< the systems that come
  void forget_preconditioner() { age_.forget(); }
  /// There is a new tangent, for which the preconditioner shall go on to serve.
  void follow(const fem::BlockMatrix<double> &tangent);
  std::string preconditioner_kind() const;
  /// How many iterations a linear solver may take before what `strengthen` changes to is worth its set-up: in a system
  /// of so many rows, which counts for static ones.
  unsigned most_iterations(std::size_t n_rows = 0) const;
  /// Goes over to the next better preconditioner for the systems that come. Whether there is one.
  bool strengthen();
  /// tangent dx = force, starting from dx. `rounded`: the tangent for iterations. Returns them.
  unsigned solve(const fem::BlockMatrix<double> &tangent, const fem::BlockMatrix<float> &rounded, fem::Vector &dx,
                 const fem::Vector &force, double tolerance, bus::Stopwatch &stopwatch);

 private:
  const SolverParameters parameters_;
  std::unique_ptr<fem::Preconditioner> preconditioner_;
  fem::PreconditionerAge age_{3};
  bool is_stiff_ = false;        ///< for incomplete factors, in dynamic systems
  bool is_static_stiff_ = false; ///< for multigrid, in static ones
};

} // namespace heartbus::mech
