#pragma once

#include "common/simd/small_matrix.h"

#include <limits>

namespace heartbus::ep {

/// The time of arrival of a front at a point x, from those at the corners of a triangle that it passes before, by the
/// straight path that arrives first (Fu, Kirby, Whitaker, SIAM J. Sci. Comput. 35 (2013) C473,
/// doi:10.1137/120881956, section 3.1):
///
///     T(x) = min over points y of the triangle of  T(y) + |x - y|,
///
/// with T(y) linear between the corners, and lengths in seconds: of vectors that `Metric` has stretched. With the edges
/// e_1, e_2 from the first corner, a from there to x, the differences d_i = T_i - T_0, G_ij = e_i . e_j and
/// g_i = e_i . a, the nearest point of the plane lies at lambda = G^-1 g, in the distance h; the path that arrives
/// first comes from lambda - rho G^-1 d, rho = h / sqrt(1 - d . G^-1 d), and
///
///     T(x) = T_0 + d . lambda + h sqrt(1 - d . G^-1 d).
///
/// Where that point is outside of the triangle, the path comes from one of its edges, for which the same holds in one
/// dimension less, or corners. Infinite: a corner that the front has not reached.
namespace arrival {

using Vector = fem::Vec3<double>;
inline constexpr double never = std::numeric_limits<double>::infinity();

/// `from`: the vectors from the corners to x; `times` there.
double from_triangle(const std::array<Vector, 3> &from, const std::array<double, 3> &times);
double from_edge(const Vector &from_0, const Vector &from_1, double time_0, double time_1);
double from_corner(const Vector &from, double time);

} // namespace arrival

/// Stretches vectors [m] to the times that a front takes along them [s]: |U a| = sqrt(a . V^-1 a), V^-1 = U^T U, with
/// the tensor of squared speeds V [m^2/s^2].
class Metric {
 public:
  explicit Metric(const fem::Mat3<double> &V);
  arrival::Vector operator()(const arrival::Vector &a) const { return U_ * a; }

 private:
  fem::Mat3<double> U_;
};

} // namespace heartbus::ep
