#include "mech_solver/interface_impedance.h"

#include <cmath>

namespace heartbus::mech {

using fem::Vector;

namespace {

constexpr unsigned n_lanczos = 10; ///< the largest eigenvalue to about a percent, which is below its safety margin

/// Of the symmetric tridiagonal matrix with this diagonal and off-diagonal, by bisection: beyond the largest eigenvalue
/// all pivots of T - x are negative.
double largest_eigenvalue(const std::vector<double> &diagonal, const std::vector<double> &off_diagonal) {
  double high = 0;
  for (std::size_t i = 0; i < diagonal.size(); ++i)
    high = std::max(high, std::abs(diagonal[i]) + (i > 0 ? off_diagonal[i - 1] : 0) +
                              (i < off_diagonal.size() ? off_diagonal[i] : 0));
  double low = -high;
  for (int bisection = 0; bisection < 60; ++bisection) {
    const double x = (low + high) / 2;
    bool beyond = true;
    double pivot = diagonal[0] - x;
    for (std::size_t i = 1; beyond && i < diagonal.size(); ++i) {
      beyond = pivot < 0;
      pivot = diagonal[i] - x - off_diagonal[i - 1] * off_diagonal[i - 1] / pivot;
    }
    (beyond && pivot < 0 ? high : low) = x;
  }
  return high;
}

} // namespace

InterfaceImpedance::InterfaceImpedance(ElasticityProblem &problem)
    : problem_(problem), surface_(problem.space(), "interface") {}

double InterfaceImpedance::uniform(double dt) {
  problem_.begin_dynamic(dt);
  problem_.linearise(problem_.d_n);
  const Vector b = problem_.unit_pressure_force();
  Vector along_x = problem_.space().make_vector(3), area(along_x);
  for (unsigned node = 0; node < problem_.space().n_owned_nodes(); ++node)
    along_x.local_element(3 * node) = 1;
  along_x.update_ghost_values();
  surface_.apply_mass(problem_.d_n, along_x, area);
  area.zero_out_ghost_values();
  return dt * (along_x * area) / (b * compliance(b));
}

/// Lanczos' method in the scalar product of M_S, orthogonalised against all former directions.
double InterfaceImpedance::smallest(double dt) {
  problem_.begin_dynamic(dt);
  problem_.linearise(problem_.d_n);
  std::vector<Vector> v, Mv;
  std::vector<double> diagonal, off_diagonal;
  Vector w = some_motion(), Mw = mass(w);
  for (unsigned j = 0; j < n_lanczos; ++j) {
    const double norm = std::sqrt(w * Mw);
    if (j > 0 && norm < 1e-6 * diagonal[0])
      break; // there are no more directions
    if (j > 0)
      off_diagonal.push_back(norm);
    w *= 1 / norm;
    Mw *= 1 / norm;
    v.push_back(w);
    Mv.push_back(Mw);
    w = compliance(Mw);
    diagonal.push_back(w * Mw);
    for (unsigned i = 0; i <= j; ++i)
      w.add(-(w * Mv[i]), v[i]);
    Mw = mass(w);
  }
  return dt / largest_eigenvalue(diagonal, off_diagonal);
}

Vector InterfaceImpedance::compliance(const Vector &f) {
  Vector w = problem_.space().make_vector(3), minus_f(f);
  minus_f *= -1;
  problem_.solve(w, minus_f);
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
