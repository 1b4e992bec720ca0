#include "mech_solver/elasticity_kernel.h"

namespace heartbus::mech {

namespace {

template <unsigned n>
using NodeVectors = std::array<fem::Vec3<VectorizedDouble>, n>;

/// A linear tetrahedron strains evenly, its frame is one, and tension enters linearly: a single point, the centroid,
/// integrates the stress exactly. Other cells take all points.
template <unsigned n>
HEARTBUS_INLINE unsigned n_strain_points(const ElasticityCells &cells) {
  return n == 4 ? 1 : cells.n_q;
}

/// Shape function a at such a point.
template <unsigned n>
HEARTBUS_INLINE double shape(const ElasticityCells &cells, unsigned q, unsigned a) {
  return n == 4 ? 0.25 : cells.shapes[q * n + a];
}

template <unsigned n>
HEARTBUS_INLINE VectorizedDouble weight(const ElasticityCells &cells, unsigned q) {
  VectorizedDouble sum = cells.JxW[q];
  for (unsigned other = 1; n == 4 && other < cells.n_q; ++other)
    sum += cells.JxW[other];
  return sum;
}

/// Gradients in the fibre frame and F R = R + sum_a d_a x g_a at one strain point; returns J.
template <unsigned n>
HEARTBUS_INLINE VectorizedDouble deformation(const ElasticityCells &cells, unsigned q, NodeVectors<n> &g,
                                             Mat3<VectorizedDouble> &F) {
  const Mat3<VectorizedDouble> &R = cells.frames[q];
  const VectorizedDouble *gradients = cells.gradients + q * n * 3;
  F = R;
  for (unsigned a = 0; a < n; ++a)
    for (unsigned j = 0; j < 3; ++j) {
      g[a][j] = R[0][j] * gradients[3 * a] + R[1][j] * gradients[3 * a + 1] + R[2][j] * gradients[3 * a + 2];
      for (unsigned i = 0; i < 3; ++i)
        F[i][j] += cells.displacement[3 * a + i] * g[a][j];
    }
  return fem::determinant(F) * fem::determinant(R); // the frame may be left-handed
}

template <unsigned n>
HEARTBUS_INLINE VectorizedDouble tension(const ElasticityCells &cells, unsigned q) {
  VectorizedDouble sum{};
  for (unsigned a = 0; a < n; ++a)
    sum += shape<n>(cells, q, a) * cells.tension[a];
  return sum;
}

HEARTBUS_INLINE void update(DeformationLimits &limits, const VectorizedDouble &J, const VectorizedDouble &exponent,
                            const VectorizedDouble &weight) {
  limits.J = (weight > 0.0) & (J < limits.J) ? J : limits.J;
  limits.exponent = (weight > 0.0) & (exponent > limits.exponent) ? exponent : limits.exponent;
  limits.volume += weight * J;
}

/// r_a += F S g_a weight
template <unsigned n>
HEARTBUS_INLINE void add_stress(const VectorizedDouble &weight, const NodeVectors<n> &g,
                                const Mat3<VectorizedDouble> &F, const Symmetric<VectorizedDouble> &S,
                                VectorizedDouble *r) {
  const Mat3<VectorizedDouble> P = weight * (F * full(S));
  for (unsigned a = 0; a < n; ++a)
    for (unsigned i = 0; i < 3; ++i)
      r[3 * a + i] += P[i][0] * g[a][0] + P[i][1] * g[a][1] + P[i][2] * g[a][2];
}

/// r_a += int N_a rho a
template <unsigned n>
HEARTBUS_INLINE void add_inertia(const ElasticityCells &cells, VectorizedDouble *r) {
  for (unsigned q = 0; q < cells.n_q; ++q) {
    const double *N = cells.shapes + q * n;
    for (unsigned i = 0; i < 3; ++i) {
      VectorizedDouble inertia{};
      for (unsigned a = 0; a < n; ++a)
        inertia += N[a] * cells.inertia[3 * a + i];
      inertia *= cells.JxW[q];
      for (unsigned a = 0; a < n; ++a)
        r[3 * a + i] += N[a] * inertia;
    }
  }
}

/// Blocks of the upper triangle only: K_ab += g_a . A . g_b weight, a <= b.
template <unsigned n>
HEARTBUS_INLINE void add_tangent(const VectorizedDouble &weight, const NodeVectors<n> &g,
                                 const std::array<std::array<VectorizedDouble, 9>, 9> &A, VectorizedDouble *K) {
  for (unsigned b = 0; b < n; ++b) {
    const fem::Vec3<VectorizedDouble> gb = {weight * g[b][0], weight * g[b][1], weight * g[b][2]};
    VectorizedDouble Ag[9][3]; // [iJ][k]
    for (unsigned row = 0; row < 9; ++row)
      for (unsigned k = 0; k < 3; ++k)
        Ag[row][k] = A[row][3 * k] * gb[0] + A[row][3 * k + 1] * gb[1] + A[row][3 * k + 2] * gb[2];
    for (unsigned a = 0; a <= b; ++a) {
      VectorizedDouble *block = K + (a * n + b) * 9;
      for (unsigned i = 0; i < 3; ++i)
        for (unsigned k = 0; k < 3; ++k)
          block[3 * i + k] += g[a][0] * Ag[3 * i][k] + g[a][1] * Ag[3 * i + 1][k] + g[a][2] * Ag[3 * i + 2][k];
    }
  }
}

/// Of the upper triangle: K_ab += int N_a N_b mass I.
template <unsigned n>
HEARTBUS_INLINE void add_mass(const ElasticityCells &cells, VectorizedDouble *K) {
  for (unsigned b = 0; b < n; ++b)
    for (unsigned a = 0; a <= b; ++a) {
      VectorizedDouble mass{};
      for (unsigned q = 0; q < cells.n_q; ++q)
        mass += (cells.shapes[q * n + a] * cells.shapes[q * n + b]) * cells.JxW[q];
      mass *= cells.mass;
      for (unsigned i = 0; i < 3; ++i)
        K[(a * n + b) * 9 + 4 * i] += mass;
    }
}

template <unsigned n>
HEARTBUS_INLINE void mirror_upper_triangle(VectorizedDouble *K) {
  for (unsigned b = 0; b < n; ++b)
    for (unsigned a = 0; a < b; ++a)
      for (unsigned i = 0; i < 3; ++i)
        for (unsigned k = 0; k < 3; ++k)
          K[(b * n + a) * 9 + 3 * k + i] = K[(a * n + b) * 9 + 3 * i + k];
}

/// What one quadrature point is told of the volume: its own J, or with mean dilatation that of its cell.
template <unsigned n, bool mean>
struct Dilatation {
  template <class Law>
  HEARTBUS_INLINE Dilatation(const Law &law, const ElasticityCells &cells) {
    if constexpr (mean) {
      for (unsigned q = 0; q < cells.n_q; ++q) {
        NodeVectors<n> g;
        Mat3<VectorizedDouble> F;
        const VectorizedDouble J = deformation<n>(cells, q, g, F);
        rest += cells.JxW[q];
        now += cells.JxW[q] * J;
      }
      const VectorizedDouble J =
          rest > 0.0 ? VectorizedDouble(now / rest) : fem::lanes(1); // a cell of another region has no weight
      const Volumetric<VectorizedDouble> volumetric = law.volumetric(J);
      pressure = volumetric.J_dU / J;
      modulus = rest > 0.0 ? VectorizedDouble(volumetric.J2_ddU / (J * J * rest)) : VectorizedDouble{};
    }
  }
  template <class Law>
  HEARTBUS_INLINE Volumetric<VectorizedDouble> at(const Law &law, const VectorizedDouble &J) const {
    if constexpr (mean)
      return {J * pressure, VectorizedDouble{}};
    else
      return law.volumetric(J);
  }
  VectorizedDouble rest{}, now{}, pressure{}, modulus{}; ///< V, v, U', U''/V
};

/// b_a += J F^{-T} g_a weight
template <unsigned n>
HEARTBUS_INLINE void add_volume_gradient(const ElasticityCells &cells, unsigned q, const NodeVectors<n> &g,
                                         const Mat3<VectorizedDouble> &F, VectorizedDouble *b) {
  const Mat3<VectorizedDouble> A = (cells.JxW[q] * fem::determinant(cells.frames[q])) * fem::cofactor(F);
  for (unsigned a = 0; a < n; ++a)
    for (unsigned i = 0; i < 3; ++i)
      b[3 * a + i] += A[i][0] * g[a][0] + A[i][1] * g[a][1] + A[i][2] * g[a][2];
}

/// K_ab += modulus b_a x b_b, a <= b.
template <unsigned n>
HEARTBUS_INLINE void add_dilatation_tangent(const VectorizedDouble &modulus, const VectorizedDouble *b,
                                            VectorizedDouble *K) {
  for (unsigned c = 0; c < n; ++c)
    for (unsigned a = 0; a <= c; ++a)
      for (unsigned i = 0; i < 3; ++i)
        for (unsigned k = 0; k < 3; ++k)
          K[(a * n + c) * 9 + 3 * i + k] += modulus * b[3 * a + i] * b[3 * c + k];
}

template <unsigned n, bool mean, class Law>
HEARTBUS_INLINE void residual(const Law &law, const ElasticityCells &cells, VectorizedDouble *r,
                              DeformationLimits &limits) {
  const Dilatation<n, mean> dilatation(law, cells);
  for (unsigned q = 0; q < n_strain_points<n>(cells); ++q) {
    NodeVectors<n> g;
    Mat3<VectorizedDouble> F;
    Symmetric<VectorizedDouble> S;
    const VectorizedDouble J = deformation<n>(cells, q, g, F), w = weight<n>(cells, q);
    const Symmetric<VectorizedDouble> C = right_cauchy_green(F);
    law.stress(C, J, dilatation.at(law, J), S);
    add_active_stress(tension<n>(cells, q), cells.dispersion[q], cells.fibres, C, S);
    update(limits, J, law.exponent(C, J), w);
    add_stress<n>(w, g, F, S, r);
  }
  add_inertia<n>(cells, r);
}

template <unsigned n, bool mean, class Law>
HEARTBUS_INLINE void residual_and_tangent(const Law &law, const ElasticityCells &cells, VectorizedDouble *r,
                                          VectorizedDouble *K, DeformationLimits &limits) {
  const Dilatation<n, mean> dilatation(law, cells);
  [[maybe_unused]] std::array<VectorizedDouble, 3 * n> volume_gradient{};
  for (unsigned q = 0; q < n_strain_points<n>(cells); ++q) {
    NodeVectors<n> g;
    Mat3<VectorizedDouble> F;
    Symmetric<VectorizedDouble> S;
    Tangent<VectorizedDouble> D;
    std::array<std::array<VectorizedDouble, 9>, 9> A;
    const VectorizedDouble J = deformation<n>(cells, q, g, F), w = weight<n>(cells, q);
    const Symmetric<VectorizedDouble> C = right_cauchy_green(F);
    law.stress_and_tangent(C, J, dilatation.at(law, J), S, D);
    add_active_stress(tension<n>(cells, q), cells.dispersion[q], cells.fibres, C, S, D);
    update(limits, J, law.exponent(C, J), w);
    elasticity_tensor(F, S, D, A);
    add_stress<n>(w, g, F, S, r);
    add_tangent<n>(w, g, A, K);
    if constexpr (mean)
      add_volume_gradient<n>(cells, q, g, F, volume_gradient.data());
  }
  if constexpr (mean)
    add_dilatation_tangent<n>(dilatation.modulus, volume_gradient.data(), K);
  add_inertia<n>(cells, r);
  add_mass<n>(cells, K);
  mirror_upper_triangle<n>(K);
}

template <unsigned n>
HEARTBUS_INLINE void active_force(const ElasticityCells &cells, VectorizedDouble *r) {
  for (unsigned q = 0; q < n_strain_points<n>(cells); ++q) {
    NodeVectors<n> g;
    Mat3<VectorizedDouble> F;
    deformation<n>(cells, q, g, F);
    Symmetric<VectorizedDouble> S{};
    add_active_stress(tension<n>(cells, q) * weight<n>(cells, q), cells.dispersion[q], cells.fibres,
                      right_cauchy_green(F), S);
    for (unsigned a = 0; a < n; ++a)
      for (unsigned i = 0; i < 3; ++i)
        r[3 * a + i] += F[i][0] * S[0] * g[a][0] + F[i][2] * S[2] * g[a][2];
  }
}

template <unsigned n>
HEARTBUS_INLINE void stretch_projection(const ElasticityCells &cells, VectorizedDouble *numerator,
                                        VectorizedDouble *weights) {
  for (unsigned q = 0; q < n_strain_points<n>(cells); ++q) {
    NodeVectors<n> g;
    Mat3<VectorizedDouble> F;
    deformation<n>(cells, q, g, F);
    const VectorizedDouble I4 = fibre_stretch_squared(cells.dispersion[q], right_cauchy_green(F));
    for (unsigned a = 0; a < n; ++a) {
      const VectorizedDouble w = shape<n>(cells, q, a) * weight<n>(cells, q);
      numerator[a] += I4 * w;
      weights[a] += w;
    }
  }
}

} // namespace

/// The number of nodes and the treatment of the volume are constants of the inner loops. In a linear tetrahedron J is
/// constant: its mean is itself.
#define HEARTBUS_FOR_CELLS(function, arguments)                                                                        \
  if (cells.nodes_per_cell == 8 && cells.mean_dilatation)                                                              \
    function<8, true> arguments;                                                                                       \
  else if (cells.nodes_per_cell == 8)                                                                                  \
    function<8, false> arguments;                                                                                      \
  else if (cells.nodes_per_cell == 4)                                                                                  \
    function<4, false> arguments;                                                                                      \
  else if (cells.mean_dilatation)                                                                                      \
    function<10, true> arguments;                                                                                      \
  else                                                                                                                 \
    function<10, false> arguments

#define HEARTBUS_KERNELS(Law, name)                                                                                    \
  HEARTBUS_SIMD void add_residual(const Law &law, const ElasticityCells &cells, VectorizedDouble *r,                   \
                                  DeformationLimits &limits) {                                                         \
    HEARTBUS_FOR_CELLS(residual, (law, cells, r, limits));                                                             \
  }                                                                                                                    \
  HEARTBUS_SIMD void add_residual_and_tangent(const Law &law, const ElasticityCells &cells, VectorizedDouble *r,       \
                                              VectorizedDouble *K, DeformationLimits &limits) {                        \
    HEARTBUS_FOR_CELLS(residual_and_tangent, (law, cells, r, K, limits));                                              \
  }
HEARTBUS_LAWS(HEARTBUS_KERNELS)
#undef HEARTBUS_KERNELS

HEARTBUS_SIMD void add_active_force(const ElasticityCells &cells, VectorizedDouble *r) {
  if (cells.nodes_per_cell == 8)
    active_force<8>(cells, r);
  else if (cells.nodes_per_cell == 4)
    active_force<4>(cells, r);
  else
    active_force<10>(cells, r);
}

HEARTBUS_SIMD void add_stretch_projection(const ElasticityCells &cells, VectorizedDouble *numerator,
                                          VectorizedDouble *weight) {
  if (cells.nodes_per_cell == 8)
    stretch_projection<8>(cells, numerator, weight);
  else if (cells.nodes_per_cell == 4)
    stretch_projection<4>(cells, numerator, weight);
  else
    stretch_projection<10>(cells, numerator, weight);
}

} // namespace heartbus::mech
