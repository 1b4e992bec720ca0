#pragma once

#include "common/simd/small_matrix.h"

#include <cmath>

namespace heartbus::fluid {

HEARTBUS_INLINE double square_root(double x) { return std::sqrt(x); }
HEARTBUS_INLINE fem::VectorizedDouble square_root(const fem::VectorizedDouble &x) {
  return fem::by_lane(x, [](double y) { return __builtin_sqrt(y); });
}

/// The intrinsic time of SUPG and PSPG (divided by the density), as Forti and Dede write it (Comput. Fluids 2015,
/// doi:10.1016/j.compfluid.2015.05.011) for BDF of order 1 and elements of degree 1:
///
///     tau = ( rho^2/dt^2 + rho^2 u.G u + C mu^2 G:G )^(-1/2),   C = 30,   G_ij = dxi_k/dx_i dxi_k/dx_j
///
/// chosen before Tezduyar's scalar form because the metric G of the mapping from the unit cell sees each direction of a
/// stretched cell. The unit cell of the formula is [-1,1]^3 for hexahedra: with deal.II's [0,1]^3, G is four times
/// larger (NavierStokesCells::unit_nodes takes care). For tetrahedra it is the regular one with edges as long, 2:
/// mapped from the unit simplex, whose edges are not alike, G would change with the numbering of a cell's vertices.
template <class T>
HEARTBUS_INLINE T momentum_tau(double rho, double mu, double dt, const fem::Vec3<T> &u, const fem::Mat3<T> &G) {
  const double C = 30;
  const T squared = rho * rho / (dt * dt) + rho * rho * fem::dot(u, G * u) + C * mu * mu * fem::contract(G, G);
  return 1. / square_root(squared);
}

/// The factor of the grad-div (LSIC) term tau_C (div u, div w) from the same source: tau_C = 1 / (tau |g|^2),
/// g_i = sum_k dxi_k/dx_i. Tetrahedra take tr G for |g|^2, which for cells with orthogonal edges is the same and does
/// not change with the numbering of vertices. Without the term the discrete divergence of coarse meshes feeds the
/// convective term: in the ventricle (492 cells, 0.2 ms) interior speeds of 1.6 m/s in ejection and 0.9 m/s in
/// isovolumetric relaxation, where 0.5 and 0.1 m/s are left with it.
template <class T>
HEARTBUS_INLINE T continuity_tau(const T &tau, const fem::Mat3<T> &unit, bool tetrahedron) {
  if (tetrahedron)
    return 1. / (tau * fem::contract(unit, unit));
  T g_squared{};
  for (unsigned i = 0; i < 3; ++i) {
    const T g = unit[0][i] + unit[1][i] + unit[2][i];
    g_squared += g * g;
  }
  return 1. / (tau * g_squared);
}

} // namespace heartbus::fluid
