#include "common/interface/nodal/alpha_limit.h"

#include "common/fem/constraints.h"

#include <cmath>
#include <deal.II/lac/lapack_full_matrix.h>

namespace heartbus::interface {

using fem::Vector;

void AlphaLimit::begin(double tau, double time) {
  tau_ = tau;
  wall_.linearise(tau, time);
  motions_.clear();
  forces_.clear();
  columns_.clear();
  exhausted_ = false;
  const Vector x = some_displacement(), Mx = wall_.interface_mass(x);
  take(x, Mx, std::sqrt(x * Mx));
}

void AlphaLimit::take(const Vector &x, const Vector &Mx, double norm) {
  motions_.push_back(x);
  motions_.back() *= 1 / norm;
  forces_.push_back(Mx);
  forces_.back() *= 1 / norm;
}

void AlphaLimit::add(const Vector &blood_velocity) {
  if (exhausted_)
    return;
  Vector answer = compliance(force());
  answer += blood_velocity;
  fem::zero_constrained(answer, wall_.constrained()); // a blood that does not know what the wall holds
  columns_.emplace_back();
  for (std::size_t i = 0; i < motions_.size(); ++i) {
    columns_.back().push_back(answer * forces_[i]);
    answer.add(-columns_.back().back(), motions_[i]);
  }
  const Vector Mx = wall_.interface_mass(answer);
  const double norm = std::sqrt(std::max(0., answer * Mx));
  exhausted_ = norm < 1e-6 * std::abs(columns_[0][0]);
  if (exhausted_)
    return;
  columns_.back().push_back(norm);
  take(answer, Mx, norm);
}

double AlphaLimit::value() const {
  constexpr double none = 2e6; // blood that yields more than any wall moves: as good as no limit
  const std::size_t n = columns_.size();
  dealii::LAPACKFullMatrix<double> hessenberg(n, n);
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t i = 0; i < std::min(n, columns_[j].size()); ++i)
      hessenberg(i, j) = columns_[j][i];
  hessenberg.compute_eigenvalues();
  double largest = 2 / none;
  for (std::size_t i = 0; i < n; ++i)
    largest = std::max(largest, hessenberg.eigenvalue(i).real());
  return 2 / largest;
}

Vector AlphaLimit::compliance(const Vector &f) {
  Vector w = wall_.answer(f);
  w *= 1 / tau_;
  return w;
}

/// Without symmetries, the same on any number of ranks.
Vector AlphaLimit::some_displacement() const {
  Vector v = wall_.space().make_vector(3);
  for (unsigned k = 0; k < v.locally_owned_size(); ++k) {
    const geometry::Point3 &p = wall_.space().points()[k / 3];
    v.local_element(k) = std::sin(1e5 * (p[0] + 1.7 * p[1] + 2.3 * p[2]) + k % 3);
  }
  fem::zero_constrained(v, wall_.constrained());
  return v;
}

} // namespace heartbus::interface
