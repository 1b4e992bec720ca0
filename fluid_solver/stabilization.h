#pragma once

#include "common/fem/small_matrix.h"

#include <cmath>

namespace heartbus::fluid {

HEARTBUS_INLINE double square_root(double x) { return std::sqrt(x); }
HEARTBUS_INLINE fem::Lanes square_root(const fem::Lanes &x) {
  return fem::by_lane(x, [](double y) { return __builtin_sqrt(y); });
}

/// The intrinsic time of SUPG and PSPG (divided by the density), as Forti and Dede write it (Comput. Fluids 2015,
/// doi:10.1016/j.compfluid.2015.05.011) for BDF of order 1 and elements of degree 1:
///
///     tau = ( rho^2/dt^2 + rho^2 u.G u + C mu^2 G:G )^(-1/2),   C = 30,   G_ij = dxi_k/dx_i dxi_k/dx_j
///
/// chosen before Tezduyar's scalar form because the metric G of the mapping from the unit cell sees each direction of a
/// stretched cell. The unit cell of the formula is [-1,1]^3 for hexahedra: with deal.II's [0,1]^3, G is four times larger
/// (NavierStokesCells::unit_nodes takes care). There is no grad-div (LSIC) term: with tau ~ dt/rho its factor rho h^2/dt
/// would spoil the mass-dominated velocity block on which both preconditioners rely.
template <class T>
HEARTBUS_INLINE T momentum_tau(double rho, double mu, double dt, const fem::Vec3<T> &u, const fem::Mat3<T> &G) {
  const double C = 30;
  const T squared = rho * rho / (dt * dt) + rho * rho * fem::dot(u, G * u) + C * mu * mu * fem::contract(G, G);
  return 1. / square_root(squared);
}

} // namespace heartbus::fluid
