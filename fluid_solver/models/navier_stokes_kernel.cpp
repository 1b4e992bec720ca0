#include "fluid_solver/models/navier_stokes_kernel.h"

#include "common/simd/small_matrix.h"
#include "fluid_solver/models/stabilization.h"

namespace heartbus::fluid {
namespace {

using fem::Mat3;
using fem::Vec3;
using fem::VectorizedDouble;

template <unsigned n>
HEARTBUS_INLINE Mat3<VectorizedDouble> deformation_gradient(const NavierStokesCells &in, unsigned q) {
  return fem::deformation_gradient(
      n, [&](unsigned a, unsigned i) { return in.ale_displacement[3 * a + i]; }, in.gradients + q * n * 3);
}

/// A nodal field of three components at quadrature point q.
template <unsigned n>
HEARTBUS_INLINE Vec3<VectorizedDouble> value(const NavierStokesCells &in, const VectorizedDouble *field, unsigned q) {
  Vec3<VectorizedDouble> v{};
  for (unsigned a = 0; a < n; ++a)
    for (unsigned i = 0; i < 3; ++i)
      v[i] += in.shapes[q * n + a] * field[3 * a + i];
  return v;
}

/// What the integrals need at the quadrature points, w being weight times J.
template <unsigned n>
struct Points {
  VectorizedDouble gradient[max_q][n][3], w_gradient[max_q][n][3]; // of the shape functions on the moved cell; times w
  VectorizedDouble div_gradient[max_q][n][3];                      // times w and tau_C of the grad-div term
  VectorizedDouble test[max_q][n];                                 // w (N_a + tau rho u*.grad N_a)
  VectorizedDouble supg[max_q][n];                                 // w tau rho u*.grad N_a
  VectorizedDouble trial[max_q][n];                                // rho (N_b / dt + u*.grad N_b)
  VectorizedDouble tau_trial[max_q][n];
  VectorizedDouble w[max_q], tau[max_q];
  Vec3<VectorizedDouble> load[max_q]; // rho u^n / dt + f
};

template <unsigned n>
HEARTBUS_INLINE void evaluate_point(const NavierStokesCells &in, unsigned q, Points<n> &p,
                                    VectorizedDouble &smallest_J) {
  const Mat3<VectorizedDouble> F = deformation_gradient<n>(in, q), cof = fem::cofactor(F);
  const VectorizedDouble J = F[0][0] * cof[0][0] + F[0][1] * cof[0][1] + F[0][2] * cof[0][2];
  smallest_J = J < smallest_J ? J : smallest_J;
  const Mat3<VectorizedDouble> F_inverse_T = (1. / J) * cof;
  p.w[q] = in.JxW[q] * J;

  Mat3<VectorizedDouble>
      unit{}; // d xi_k / d x_i: the coordinates of the unit cell are themselves finite element functions
  for (unsigned a = 0; a < n; ++a) {
    const VectorizedDouble *reference = &in.gradients[(q * n + a) * 3];
    for (unsigned i = 0; i < 3; ++i) {
      const VectorizedDouble g =
          F_inverse_T[i][0] * reference[0] + F_inverse_T[i][1] * reference[1] + F_inverse_T[i][2] * reference[2];
      p.gradient[q][a][i] = g;
      p.w_gradient[q][a][i] = p.w[q] * g;
      for (unsigned k = 0; k < 3; ++k)
        unit[k][i] += in.unit_nodes[3 * a + k] * g;
    }
  }
  const Vec3<VectorizedDouble> u_star = value<n>(in, in.convection, q), u_n = value<n>(in, in.old_velocity, q);
  p.tau[q] = momentum_tau(in.rho, in.mu, in.dt, u_star, fem::transpose(unit) * unit);
  const VectorizedDouble tau_C = continuity_tau(p.tau[q], unit, n == 4);
  for (unsigned a = 0; a < n; ++a)
    for (unsigned i = 0; i < 3; ++i)
      p.div_gradient[q][a][i] = tau_C * p.w_gradient[q][a][i];
  for (unsigned i = 0; i < 3; ++i)
    p.load[q][i] = in.inertia * in.rho / in.dt * u_n[i] + (in.force ? in.force[3 * q + i] : VectorizedDouble{});

  for (unsigned a = 0; a < n; ++a) {
    const VectorizedDouble *g = p.gradient[q][a];
    const VectorizedDouble convective = in.rho * (u_star[0] * g[0] + u_star[1] * g[1] + u_star[2] * g[2]);
    const double N = in.shapes[q * n + a];
    p.supg[q][a] = p.w[q] * p.tau[q] * convective;
    p.test[q][a] = p.w[q] * N + p.supg[q][a];
    p.trial[q][a] = in.inertia * in.rho / in.dt * N + convective;
    p.tau_trial[q][a] = p.tau[q] * p.trial[q][a];
  }
}

/// int of (left gradient of N_a) (x) grad N_b
template <unsigned n>
HEARTBUS_INLINE Mat3<VectorizedDouble> outer_product(unsigned n_q, const VectorizedDouble left[max_q][n][3],
                                                     const VectorizedDouble right[max_q][n][3], unsigned a,
                                                     unsigned b) {
  Mat3<VectorizedDouble> H{};
  for (unsigned q = 0; q < n_q; ++q)
    for (unsigned i = 0; i < 3; ++i)
      for (unsigned j = 0; j < 3; ++j)
        H[i][j] += left[q][a][i] * right[q][b][j];
  return H;
}

/// The 4x4 block between nodes a (row) and b (column). Three passes over the points: each has as many sums as there are
/// registers.
template <unsigned n>
HEARTBUS_INLINE void node_block(const NavierStokesCells &in, const Points<n> &p, unsigned a, unsigned b,
                                VectorizedDouble *K) {
  VectorizedDouble inertia{}, pressure_laplacian{}; // transport with its SUPG part; PSPG
  Vec3<VectorizedDouble> G{}, D{};                  // pressure gradient, divergence
  for (unsigned q = 0; q < in.n_q; ++q) {
    const VectorizedDouble *wg_a = p.w_gradient[q][a], *g_b = p.gradient[q][b];
    const double N_b = in.shapes[q * n + b];
    const VectorizedDouble wN_a = in.shapes[q * n + a] * p.w[q];
    inertia += p.test[q][a] * p.trial[q][b];
    VectorizedDouble laplacian{};
    for (unsigned i = 0; i < 3; ++i) {
      laplacian += wg_a[i] * g_b[i];
      G[i] += p.supg[q][a] * g_b[i] - N_b * wg_a[i];
      D[i] += wN_a * g_b[i] + p.tau_trial[q][b] * wg_a[i];
    }
    pressure_laplacian += p.tau[q] * laplacian;
  }
  const double P = in.pressure_scale;
  for (unsigned i = 0; i < 3; ++i) {
    K[4 * i + 3] = P * G[i];
    K[12 + i] = P * D[i];
  }
  K[15] = P * P * pressure_laplacian;
  const Mat3<VectorizedDouble> H = outer_product<n>(in.n_q, p.w_gradient, p.gradient, a, b);
  const VectorizedDouble diagonal = inertia + in.mu * (H[0][0] + H[1][1] + H[2][2]);
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      K[4 * i + j] = in.mu * H[j][i] + (i == j ? diagonal : VectorizedDouble{});
  const Mat3<VectorizedDouble> grad_div = outer_product<n>(in.n_q, p.div_gradient, p.gradient, a, b);
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      K[4 * i + j] += grad_div[i][j];
}

/// Residual = K state - load.
template <unsigned n>
HEARTBUS_INLINE void residual(const NavierStokesCells &in, const Points<n> &p, const VectorizedDouble *K,
                              VectorizedDouble *r) {
  for (unsigned a = 0; a < n; ++a) {
    VectorizedDouble sum[4] = {};
    for (unsigned b = 0; b < n; ++b)
      for (unsigned i = 0; i < 4; ++i)
        for (unsigned j = 0; j < 4; ++j)
          sum[i] += K[((a * n + b) * 4 + i) * 4 + j] * in.state[4 * b + j];
    for (unsigned q = 0; q < in.n_q; ++q) {
      const Vec3<VectorizedDouble> &f = p.load[q];
      for (unsigned i = 0; i < 3; ++i) {
        sum[i] -= p.test[q][a] * f[i];
        sum[3] -= in.pressure_scale * p.tau[q] * p.w_gradient[q][a][i] * f[i];
      }
    }
    for (unsigned i = 0; i < 4; ++i)
      r[4 * a + i] = sum[i];
  }
}

template <unsigned n>
HEARTBUS_INLINE void integrate(const NavierStokesCells &in, VectorizedDouble *K, VectorizedDouble *r,
                               VectorizedDouble &smallest_J) {
  Points<n> points;
  smallest_J = fem::lanes(1e300);
  for (unsigned q = 0; q < in.n_q; ++q)
    evaluate_point<n>(in, q, points, smallest_J);
  for (unsigned a = 0; a < n; ++a)
    for (unsigned b = 0; b < n; ++b)
      node_block<n>(in, points, a, b, &K[(a * n + b) * 16]);
  residual<n>(in, points, K, r);
}

template <unsigned n>
HEARTBUS_INLINE void average(const NavierStokesCells &in, VectorizedDouble &volume, VectorizedDouble &pressure) {
  volume = pressure = VectorizedDouble{};
  for (unsigned q = 0; q < in.n_q; ++q) {
    const VectorizedDouble w = in.JxW[q] * fem::determinant(deformation_gradient<n>(in, q));
    VectorizedDouble p{};
    for (unsigned a = 0; a < n; ++a)
      p += in.shapes[q * n + a] * in.state[4 * a + 3];
    volume += w;
    pressure += w * in.pressure_scale * p;
  }
}

} // namespace

HEARTBUS_SIMD void integrate_navier_stokes(const NavierStokesCells &cells, VectorizedDouble *K, VectorizedDouble *r,
                                           VectorizedDouble &smallest_J) {
  if (cells.nodes_per_cell == 8)
    integrate<8>(cells, K, r, smallest_J);
  else
    integrate<4>(cells, K, r, smallest_J);
}

HEARTBUS_SIMD void integrate_pressure(const NavierStokesCells &cells, VectorizedDouble &volume,
                                      VectorizedDouble &pressure) {
  if (cells.nodes_per_cell == 8)
    average<8>(cells, volume, pressure);
  else
    average<4>(cells, volume, pressure);
}

} // namespace heartbus::fluid
