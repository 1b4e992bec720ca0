#include "mech_solver/interface_impedance.h"

#include <cmath>
#include <deal.II/lac/lapack_full_matrix.h>

namespace heartbus::mech {

using fem::Vector;

InterfaceImpedance::InterfaceImpedance(ElasticityProblem &problem)
    : problem_(problem), surface_(problem.space(), "interface") {}

void InterfaceImpedance::begin(double dt) {
  dt_ = dt;
  problem_.begin_dynamic(dt);
  problem_.linearise(problem_.d_n);
  motions_.clear();
  forces_.clear();
  columns_.clear();
  exhausted_ = false;
  const Vector x = some_motion(), Mx = mass(x);
  take(x, Mx, std::sqrt(x * Mx));
}

void InterfaceImpedance::take(const Vector &x, const Vector &Mx, double norm) {
  motions_.push_back(x);
  motions_.back() *= 1 / norm;
  forces_.push_back(Mx);
  forces_.back() *= 1 / norm;
}

void InterfaceImpedance::add(const Vector &blood_velocity) {
  if (exhausted_)
    return;
  Vector answer = compliance(force());
  answer += blood_velocity;
  fem::zero_constrained(answer, problem_.constrained()); // a blood that does not know what the wall holds
  columns_.emplace_back();
  for (std::size_t i = 0; i < motions_.size(); ++i) {
    columns_.back().push_back(answer * forces_[i]);
    answer.add(-columns_.back().back(), motions_[i]);
  }
  const Vector Mx = mass(answer);
  const double norm = std::sqrt(std::max(0., answer * Mx));
  exhausted_ = norm < 1e-6 * std::abs(columns_[0][0]);
  if (exhausted_)
    return;
  columns_.back().push_back(norm);
  take(answer, Mx, norm);
}

double InterfaceImpedance::alpha_limit() const {
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

Vector InterfaceImpedance::compliance(const Vector &f) {
  Vector w = problem_.space().make_vector(3);
  problem_.respond(w, f);
  w *= 1 / dt_;
  return w;
}

Vector InterfaceImpedance::mass(const Vector &x) const {
  Vector y = problem_.space().make_vector(3), ghosted(x);
  ghosted.update_ghost_values();
  surface_.apply_mass(problem_.d_n, ghosted, y);
  y.zero_out_ghost_values();
  fem::zero_constrained(y, problem_.constrained());
  return y;
}

/// Without symmetries, the same on any number of ranks.
Vector InterfaceImpedance::some_motion() const {
  Vector v = problem_.space().make_vector(3);
  for (unsigned k = 0; k < v.locally_owned_size(); ++k) {
    const geometry::Point3 &p = problem_.space().points()[k / 3];
    v.local_element(k) = std::sin(1e5 * (p[0] + 1.7 * p[1] + 2.3 * p[2]) + k % 3);
  }
  fem::zero_constrained(v, problem_.constrained());
  return v;
}

} // namespace heartbus::mech
