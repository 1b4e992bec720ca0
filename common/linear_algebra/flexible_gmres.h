#pragma once

#include "common/linear_algebra/gram_schmidt_kernel.h"
#include "common/linear_algebra/linear_solver.h"

#include <deal.II/base/mpi.h>
#include <deal.II/lac/vector_memory.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace heartbus::fem {

/// GMRES with preconditioning from the right, the residual it knows being the true one, for preconditioners of any kind
/// (Y. Saad, A flexible inner-outer preconditioned GMRES algorithm, doi:10.1137/0914028). Where a few iterations are
/// enough, sums over the ranks are what counts: classical Gram-Schmidt takes one an iteration, of the products with the
/// whole basis and the square of the norm at once, and one more after many. deal.II's takes k + 2 in iteration
/// k, and one product and one application of the preconditioner more a solve, for a start that is zero here and a
/// solution that is a sum of the preconditioned vectors.
template <class Matrix>
class FlexibleGMRES {
 public:
  FlexibleGMRES(const Matrix &A, const Preconditioner &preconditioner, const Vector &like)
      : A_(A), preconditioner_(preconditioner), like_(like) {}

  unsigned n_iterations = 0;

  /// Adds to x what reduces the residual `r` (its norm `size`) to `wanted`, in at most so many iterations. Returns the
  /// norm of what is left, also when that is not finite. Collective.
  double improve(Vector &x, const Vector &r, double size, double wanted, unsigned at_most) {
    basis_.clear();
    preconditioned_.clear();
    R_.clear();
    rotations_.clear();
    g_ = {size};
    loss_ = 1e-16;
    Vector &first = add_to(basis_);
    first.equ(1 / size, r);
    while (true) {
      const std::size_t k = R_.size();
      Vector &z = add_to(preconditioned_), &w = add_to(basis_);
      preconditioner_.vmult(z, *basis_[k]);
      A_.vmult(w, z);
      const double length = orthogonalise(w);
      rotate(length);
      ++n_iterations;
      const double residual = std::abs(g_.back());
      if (!(residual > wanted) || k + 1 == at_most || length == 0)
        break;
      w *= 1 / length;
    }
    add_solution(x);
    return std::abs(g_.back());
  }

 private:
  using Vectors = std::vector<dealii::VectorMemory<Vector>::Pointer>;
  struct Rotation {
    double c, s;
  };

  Vector &add_to(Vectors &vectors) {
    vectors.emplace_back(memory_);
    vectors.back()->reinit(like_, true);
    return *vectors.back();
  }

  /// Against the basis before it; appends the column of coefficients to R. Returns the norm of what is left of w. Once
  /// is enough as long as the basis is well conditioned: what is lost of its orthogonality is about the rounding error
  /// times the square of its condition, for which the lengths that are lost stand here (L. Giraud et al., The loss of
  /// orthogonality in the Gram-Schmidt orthogonalization process, doi:10.1016/j.camwa.2005.08.009).
  double orthogonalise(Vector &w) {
    constexpr double tolerated = 1e-8;
    R_.emplace_back(basis_.size() - 1);
    auto [before, left] = subtract_projection(w);
    loss_ *= before / std::max(left, 1e-16 * before);
    if (loss_ > tolerated) {
      left = subtract_projection(w).second;
      loss_ = tolerated;
    }
    return std::sqrt(std::max(left, 0.));
  }

  /// Returns the squares of the norm before and after.
  std::pair<double, double> subtract_projection(Vector &w) {
    std::vector<double> &column = R_.back();
    std::vector<const double *> basis;
    for (std::size_t j = 0; j < column.size(); ++j)
      basis.push_back(basis_[j]->begin());
    multiply_by_basis(w.locally_owned_size(), basis, w.begin(), products_);
    dealii::Utilities::MPI::sum(products_, w.get_mpi_communicator(), products_);
    subtract_basis(w.locally_owned_size(), basis, products_.data(), w.begin());
    double left = products_.back();
    for (std::size_t j = 0; j < column.size(); ++j) {
      column[j] += products_[j];
      left -= products_[j] * products_[j];
    }
    return {products_.back(), left};
  }

  /// Givens rotations turn the least-squares problem of the coefficients into a triangular system R y = g.
  void rotate(double length) {
    std::vector<double> &column = R_.back();
    for (std::size_t j = 0; j < rotations_.size(); ++j) {
      const auto [c, s] = rotations_[j];
      const double upper = column[j], lower = column[j + 1];
      column[j] = c * upper + s * lower;
      column[j + 1] = c * lower - s * upper;
    }
    const double hypotenuse = std::hypot(column.back(), length);
    const Rotation rotation{column.back() / hypotenuse, length / hypotenuse};
    column.back() = hypotenuse;
    g_.push_back(-rotation.s * g_.back());
    g_[g_.size() - 2] *= rotation.c;
    rotations_.push_back(rotation);
  }

  void add_solution(Vector &x) {
    y_ = g_;
    for (std::size_t k = R_.size(); k-- > 0;) {
      for (std::size_t j = k + 1; j < R_.size(); ++j)
        y_[k] -= R_[j][k] * y_[j];
      y_[k] /= R_[k][k];
      x.add(y_[k], *preconditioned_[k]);
    }
  }

  const Matrix &A_;
  const Preconditioner &preconditioner_;
  const Vector &like_;
  dealii::GrowingVectorMemory<Vector> memory_;
  Vectors basis_, preconditioned_;
  std::vector<std::vector<double>> R_; ///< by column
  std::vector<Rotation> rotations_;
  double loss_ = 0; ///< estimate of the basis' deviation from orthogonality
  std::vector<double> g_, y_, products_;
};

} // namespace heartbus::fem
