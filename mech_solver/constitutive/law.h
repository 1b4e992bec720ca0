#pragma once

#include "common/config/section.h"
#include "common/simd/small_matrix.h"
#include "common/simd/vectorized_math.h"

#include <array>

namespace heartbus::mech {

using fem::exp;
using fem::log;
using fem::Mat3;
using fem::sqrt;
using fem::VectorizedDouble;

/// A constitutive law is a small struct: its parameters with their keys in the scene,
///
///     double ..., kappa                           the last one its bulk modulus [Pa]
///     static constexpr const char *meaning        what it is, in a few words
///     void describe(config::Section &)            keys, units and ranges of the parameters
///
/// and pure functions of the deformation, for T = double or fem::VectorizedDouble:
///
///     T energy(F)                                 W, from which the unit tests derive everything else [Pa]
///     T exponent(C, J)                            the largest argument of its exponentials, 0 when there is none
///     Volumetric<T> volumetric(J)                 of its energy of volume U(J), a part of W
///     void stress(C, J, volumetric, S)            second Piola-Kirchhoff stress S = dW/dE
///     void stress_and_tangent(C, J, volumetric, S, D)     and the material tangent D = dS/dE
///
/// The volumetric part is handed back to the law, so that whoever evaluates U at the mean J of a cell (mean dilatation,
/// elasticity_kernel.h) can have that instead.
///
/// All tensors are given in the fibre frame: F's columns are the images of the fibre, sheet and normal directions and
/// C = F^T F. So a law never sees the directions themselves, and rotating a specimen is the caller's business. J is
/// passed on its own because a left-handed frame would turn its sign.
///
/// laws.h has the list of all laws.
///
/// Symmetric tensors are six numbers in the order ff, ss, nn, fs, fn, sn (tensor components, no factors of two), and
/// D[ij][kl] = dS_ij/dE_kl with both minor symmetries, so that dS_ij = sum_kl D[ij][kl] dE_kl over all nine pairs.
template <class T>
using Symmetric = std::array<T, 6>;
template <class T>
using Tangent = std::array<std::array<T, 6>, 6>;

inline constexpr unsigned voigt[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
inline constexpr unsigned pair_row[6] = {0, 1, 2, 0, 0, 1}, pair_column[6] = {0, 1, 2, 1, 2, 2};

/// Trial states beyond these are refused, so that a line search backs off before anything overflows.
inline constexpr double smallest_J = 0.1, largest_exponent = 30;

/// C = F^T F.
template <class T>
HEARTBUS_INLINE Symmetric<T> right_cauchy_green(const Mat3<T> &F) {
  Symmetric<T> C;
  for (unsigned v = 0; v < 6; ++v) {
    const unsigned i = pair_row[v], j = pair_column[v];
    C[v] = F[0][i] * F[0][j] + F[1][i] * F[1][j] + F[2][i] * F[2][j];
  }
  return C;
}

/// Of an energy of volume U(J) [Pa].
template <class T>
struct Volumetric {
  T J_dU;   ///< J U'(J)
  T J2_ddU; ///< J^2 U''(J)
};

/// C^{-1}, given det C = J^2.
template <class T>
HEARTBUS_INLINE Symmetric<T> inverse_symmetric(const Symmetric<T> &C, const T &J) {
  const T d = 1.0 / (J * J);
  return {d * (C[1] * C[2] - C[5] * C[5]), d * (C[0] * C[2] - C[4] * C[4]), d * (C[0] * C[1] - C[3] * C[3]),
          d * (C[4] * C[5] - C[3] * C[2]), d * (C[3] * C[5] - C[4] * C[1]), d * (C[3] * C[4] - C[5] * C[0])};
}

/// A volumetric energy U(J) contributes S = J U' C^{-1}, D = J (U' + J U'') C^{-1} x C^{-1} - 2 J U' C^{-1} (.) C^{-1},
/// where (X (.) X) dE = X dE X.
template <class T>
HEARTBUS_INLINE void add_volumetric_stress(const Symmetric<T> &C_inverse, const T &J_dU, Symmetric<T> &S) {
  for (unsigned v = 0; v < 6; ++v)
    S[v] += J_dU * C_inverse[v];
}

/// D += outer X x X + inner X (.) X for a symmetric X.
template <class T>
HEARTBUS_INLINE void add_products(const Symmetric<T> &X, const T &outer, const T &inner, Tangent<T> &D) {
  const T half = 0.5 * inner;
  for (unsigned v = 0; v < 6; ++v)
    for (unsigned w = v; w < 6; ++w) {
      const unsigned i = pair_row[v], j = pair_column[v], k = pair_row[w], l = pair_column[w];
      D[v][w] += outer * X[v] * X[w] + half * (X[voigt[i][k]] * X[voigt[j][l]] + X[voigt[i][l]] * X[voigt[j][k]]);
      D[w][v] = D[v][w];
    }
}

template <class T>
HEARTBUS_INLINE Mat3<T> full(const Symmetric<T> &S) {
  Mat3<T> M;
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      M[i][j] = S[voigt[i][j]];
  return M;
}

/// P = F S, the first Piola-Kirchhoff stress (its second index in the fibre frame, as F's).
template <class Law, class T>
HEARTBUS_INLINE Mat3<T> first_piola(const Law &law, const Mat3<T> &F) {
  Symmetric<T> S;
  const T J = fem::determinant(F);
  law.stress(right_cauchy_green(F), J, law.volumetric(J), S);
  return F * full(S);
}

/// The elasticity tensor A[iJ][kL] = dP_iJ/dF_kL = F_im D[mJ][nL] F_kn + delta_ik S_JL, stored at [3i + J][3k + L].
template <class T>
HEARTBUS_INLINE void elasticity_tensor(const Mat3<T> &F, const Symmetric<T> &S, const Tangent<T> &D,
                                       std::array<std::array<T, 9>, 9> &A) {
  std::array<std::array<T, 6>, 9> FD; // F_im D[mJ][w]
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      for (unsigned w = 0; w < 6; ++w)
        FD[3 * i + j][w] = F[i][0] * D[voigt[0][j]][w] + F[i][1] * D[voigt[1][j]][w] + F[i][2] * D[voigt[2][j]][w];
  for (unsigned k = 0; k < 3; ++k)
    for (unsigned l = 0; l < 3; ++l)
      for (unsigned r = 0; r < 9; ++r)
        A[r][3 * k + l] = FD[r][voigt[0][l]] * F[k][0] + FD[r][voigt[1][l]] * F[k][1] + FD[r][voigt[2][l]] * F[k][2];
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      for (unsigned l = 0; l < 3; ++l)
        A[3 * i + j][3 * i + l] += S[voigt[j][l]];
}

} // namespace heartbus::mech
