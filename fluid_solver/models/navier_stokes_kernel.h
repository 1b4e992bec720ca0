#pragma once

#include "common/simd/vectorized_double.h"

namespace heartbus::fluid {

/// A batch of cells of the linearised, stabilised Navier-Stokes equations on the moving mesh, integrated on the
/// reference cell (paper, eq. (navierstokes-discrete)): with F = I + grad d, J = det F, gradients F^{-T} grad N, u* =
/// u^n - u_ALE,
///
///     r_M = rho (u - u^n)/dt + rho (u*.grad) u + grad p - f
///     a(w, q) = ( rho (u - u^n)/dt + rho (u*.grad) u - f, w ) + 2 mu ( eps(u), eps(w) ) - ( p, div w ) + ( div u, q )
///               + sum_K ( tau ( rho (u*.grad) w + grad q ), r_M )_K + ( tau_C div w, div u )_K
///
/// SUPG-PSPG-LSIC with tau and tau_C of stabilization.h; second derivatives vanish on P1 and are neglected on Q1.
/// Unknowns of a node: u, v, w and the pressure divided by `pressure_scale`, by which the continuity rows are
/// multiplied too: all 4x4 blocks then are of one size, and a Krylov method's norm sees the mass balance.
struct NavierStokesCells {
  // discretisation, reference configuration (see fem::LagrangeSpace)
  unsigned nodes_per_cell = 0, n_q = 0;
  const double *shapes = nullptr;                   ///< [q][a]
  const fem::VectorizedDouble *gradients = nullptr; ///< [q][a][3]
  const fem::VectorizedDouble *JxW = nullptr;       ///< [q]
  const double *unit_nodes =
      nullptr; ///< [a][3] nodes of the unit cell: [-1,1]^3, or the regular tetrahedron of edges 2
  // physics
  double rho = 0, mu = 0, dt = 0, pressure_scale = 1;
  double inertia = 1; ///< factor of rho (u - u^n)/dt
  // fields at the nodes of the cells
  const fem::VectorizedDouble *ale_displacement = nullptr; ///< [a][3] d^{n+1}
  const fem::VectorizedDouble *convection = nullptr;       ///< [a][3] u*
  const fem::VectorizedDouble *old_velocity = nullptr;     ///< [a][3] u^n
  const fem::VectorizedDouble *state = nullptr;            ///< [a][4] where the residual is taken
  const fem::VectorizedDouble *force = nullptr;            ///< [q][3] body force per current volume, or null
};

/// K: the matrix, [((a*n + b)*4 + i)*4 + j]; r: the residual a at `state`, [a][4]; smallest_J: of each cell. The
/// pressure entries are scaled as described above.
void integrate_navier_stokes(const NavierStokesCells &cells, fem::VectorizedDouble *K, fem::VectorizedDouble *r,
                             fem::VectorizedDouble &smallest_J);

/// Volume of the moved cells and integral over them of the (unscaled) pressure in `state`.
void integrate_pressure(const NavierStokesCells &cells, fem::VectorizedDouble &volume, fem::VectorizedDouble &pressure);

/// Largest number of nodes and quadrature points of a cell that the kernel can take.
inline constexpr unsigned max_nodes = 8, max_q = 8;

} // namespace heartbus::fluid
