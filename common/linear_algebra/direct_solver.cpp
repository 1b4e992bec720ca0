#include "common/linear_algebra/direct_solver.h"

#include "common/base/failure.h"
#include "common/linear_algebra/trilinos_copy.h"

#include <Amesos_Mumps.h>
#include <Epetra_LinearProblem.h>
#include <Epetra_Vector.h>

#include <algorithm>

namespace heartbus::fem {

namespace {

class DirectSolver : public Preconditioner {
 public:
  explicit DirectSolver(const BlockMatrix<double> &matrix)
      : matrix_(trilinos_copy(matrix)), solution_(matrix_->RowMap()), force_(matrix_->RowMap()),
        problem_(matrix_.get(), &solution_, &force_), mumps_(problem_) {
    Teuchos::ParameterList parameters;
    parameters.set("MaxProcs", -3); // all of them
    parameters.set("OutputLevel", 0);
    mumps_.SetParameters(parameters);
    factorise();
  }
  void vmult(Vector &y, const Vector &x) const override {
    std::copy_n(x.begin(), x.locally_owned_size(), force_.Values());
    mumps_.Solve();
    if (const int error = mumps_.GetINFOG()[0]; error < 0)
      throw Failure(ExitCode::not_converged,
                    "MUMPS cannot solve with its factors (its error " + std::to_string(error) + ")");
    std::copy_n(solution_.Values(), y.locally_owned_size(), y.begin());
  }

 private:
  /// Pivoting may need more memory than was foreseen: 50 % more are allowed at first, then twice as much each time.
  void factorise() {
    constexpr int more_memory = 14, too_few_integers = -8, too_few_numbers = -9; // of the MUMPS 5 user's guide
    int error = too_few_numbers;
    for (int percent = 50; (error == too_few_integers || error == too_few_numbers) && percent <= 1600; percent *= 2) {
      mumps_.SetICNTL(more_memory, percent);
      mumps_.SymbolicFactorization();
      if (error = mumps_.GetINFOG()[0]; error >= 0) {
        mumps_.NumericFactorization();
        error = mumps_.GetINFOG()[0];
      }
    }
    if (error < 0)
      throw Failure(
          ExitCode::not_converged,
          "MUMPS cannot factorise a matrix of " + std::to_string(matrix_->NumGlobalRows()) + " rows (its error " +
              std::to_string(error) +
              "): it is singular, i.e. something can move freely, or there is too little memory for its factors");
  }

  std::unique_ptr<Epetra_CrsMatrix> matrix_;
  mutable Epetra_Vector solution_, force_;
  Epetra_LinearProblem problem_;
  mutable Amesos_Mumps mumps_;
};

} // namespace

std::unique_ptr<Preconditioner> make_direct_solver(const BlockMatrix<double> &matrix) {
  return std::make_unique<DirectSolver>(matrix);
}

} // namespace heartbus::fem
