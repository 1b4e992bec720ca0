#include "ep_solver/arrival.h"

#include <algorithm>
#include <cmath>

namespace heartbus::ep {

namespace arrival {

namespace {

Vector minus(const Vector &a, const Vector &b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

} // namespace

double from_corner(const Vector &from, double time) { return time + std::sqrt(fem::dot(from, from)); }

double from_edge(const Vector &from_0, const Vector &from_1, double time_0, double time_1) {
  const double d = time_1 - time_0;
  if (std::isfinite(d)) {
    const Vector e = minus(from_0, from_1);
    const double G = fem::dot(e, e), lambda = fem::dot(e, from_0) / G, q = d * d / G;
    const double h_squared = fem::dot(from_0, from_0) - lambda * lambda * G;
    if (q < 1 && h_squared > 0) {
      const double h = std::sqrt(h_squared), root = std::sqrt(1 - q), source = lambda - h / root * d / G;
      if (source >= 0 && source <= 1)
        return time_0 + d * lambda + h * root;
    }
  }
  return std::min(from_corner(from_0, time_0), from_corner(from_1, time_1));
}

double from_triangle(const std::array<Vector, 3> &from, const std::array<double, 3> &times) {
  const double d1 = times[1] - times[0], d2 = times[2] - times[0];
  if (std::isfinite(d1) && std::isfinite(d2)) {
    const Vector &a = from[0], e1 = minus(a, from[1]), e2 = minus(a, from[2]);
    const double G11 = fem::dot(e1, e1), G12 = fem::dot(e1, e2), G22 = fem::dot(e2, e2), det = G11 * G22 - G12 * G12;
    const double g1 = fem::dot(e1, a), g2 = fem::dot(e2, a);
    const double lambda1 = (G22 * g1 - G12 * g2) / det, lambda2 = (G11 * g2 - G12 * g1) / det;
    const double c1 = (G22 * d1 - G12 * d2) / det, c2 = (G11 * d2 - G12 * d1) / det, q = c1 * d1 + c2 * d2;
    const double h_squared = fem::dot(a, a) - lambda1 * g1 - lambda2 * g2;
    if (q < 1 && h_squared > 0) {
      const double h = std::sqrt(h_squared), root = std::sqrt(1 - q), rho = h / root;
      const double source1 = lambda1 - rho * c1, source2 = lambda2 - rho * c2;
      if (source1 >= 0 && source2 >= 0 && source1 + source2 <= 1)
        return times[0] + d1 * lambda1 + d2 * lambda2 + h * root;
    }
  }
  return std::min({from_edge(from[0], from[1], times[0], times[1]), from_edge(from[1], from[2], times[1], times[2]),
                   from_edge(from[2], from[0], times[2], times[0])});
}

} // namespace arrival

/// By Cholesky's factors.
Metric::Metric(const fem::Mat3<double> &V) {
  const fem::Mat3<double> M = fem::inverse(V);
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = i; j < 3; ++j) {
      double rest = M[i][j];
      for (unsigned k = 0; k < i; ++k)
        rest -= U_[k][i] * U_[k][j];
      U_[i][j] = j == i ? std::sqrt(rest) : rest / U_[i][i];
    }
}

} // namespace heartbus::ep
