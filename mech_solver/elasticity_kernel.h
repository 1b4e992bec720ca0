#pragma once

#include "mech_solver/active/active_stress.h"
#include "mech_solver/constitutive/laws.h"

namespace heartbus::mech {

/// A batch of cells of the elastodynamics equation, weak form over the reference configuration (paper, eq.
/// (elastodynamics)):
///
///     r(phi) = int rho a . phi + int (P_pas(F) + P_act(F, T)) : grad phi
///
/// evaluated in the fibre frame: with R = [f s n] and g = R^T grad N, F R = R + sum_a d_a x g_a and P R = (F R) S, so
/// that a law sees the frame's components only (constitutive/law.h), and r_a = (F R) S g_a. The tangent uses the tensor
/// A = dP/dF of one quadrature point: K_ab = g_a . A . g_b, 27 products for each pair of nodes.
///
/// With mean dilatation (Nagtegaal, Parks, Rice 1974, doi:10.1016/0045-7825(74)90032-2; Simo, Taylor, Pister 1985,
/// doi:10.1016/0045-7825(85)90033-7) the energy of volume of a cell is V U(v / V), with its volumes V at rest and v
/// as it is, in place of int U(J): one condition a cell on its volume, where one a quadrature point would lock it.
/// Its pressure U'(v/V) is the same in all of the cell, and with b_a = dv/dd_a the tangent has the additional part
/// U''(v/V)/V b_a x b_b.
struct ElasticityCells {
  // discretisation, reference configuration (see fem::LagrangeSpace)
  unsigned nodes_per_cell = 0, n_q = 0;
  const double *shapes = nullptr;                 ///< [q][a]
  const VectorizedDouble *gradients = nullptr;    ///< [q][a][3]
  const VectorizedDouble *JxW = nullptr;          ///< [q]; cells of weight zero are left out
  const Mat3<VectorizedDouble> *frames = nullptr; ///< [q] columns f, s, n: orthonormal
  const VectorizedDouble *dispersion = nullptr;   ///< [q] share of the fibres along n
  // fields at the nodes of the cells
  const VectorizedDouble *displacement = nullptr; ///< [a][3] [m]
  const VectorizedDouble *inertia = nullptr;      ///< [a][3] rho (a - gravity) [N/m^3]
  const VectorizedDouble *tension = nullptr;      ///< [a] active tension [Pa]
  ActiveFibres fibres;
  double mass = 0; ///< d(rho a)/dd: rho / dt^2, or 0 [kg/(m^3 s^2)]
  bool mean_dilatation = false;
};

/// The worst deformation met, and the volume [m^3], by cell.
struct DeformationLimits {
  VectorizedDouble J = fem::lanes(1e300), exponent = VectorizedDouble{}, volume = VectorizedDouble{};
};

/// Largest number of nodes of a cell that the kernels take.
inline constexpr unsigned max_nodes_per_cell = 10;

/// For each law: r [a][3] += residual; and also K [((a*n + b)*3 + i)*3 + j] += tangent, symmetric.
#define HEARTBUS_DECLARE(Law, name)                                                                                    \
  void add_residual(const Law &law, const ElasticityCells &cells, VectorizedDouble *r, DeformationLimits &limits);     \
  void add_residual_and_tangent(const Law &law, const ElasticityCells &cells, VectorizedDouble *r,                     \
                                VectorizedDouble *K, DeformationLimits &limits);
HEARTBUS_LAWS(HEARTBUS_DECLARE)
#undef HEARTBUS_DECLARE

/// r [a][3] += int P_act : grad phi alone. P_act is linear in the tension: a difference of tensions gives a difference
/// of forces.
void add_active_force(const ElasticityCells &cells, VectorizedDouble *r);

/// Lumped L2 projection of I4: numerator [a] += int I4 phi_a, weight [a] += int phi_a.
void add_stretch_projection(const ElasticityCells &cells, VectorizedDouble *numerator, VectorizedDouble *weight);

} // namespace heartbus::mech
