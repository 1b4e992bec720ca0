#pragma once

#include "mech_solver/constitutive/law.h"

namespace heartbus::mech {

/// Holzapfel and Ogden's orthotropic law of passive myocardium (2009, section 5, doi:10.1098/rsta.2009.0091) with a
/// volumetric penalty:
///
///     W = a/2b (e^{b (I1 - 3)} - 1) + sum over i in {f, s} of a_i/2b_i (e^{b_i x_i^2} - 1)
///         + a_fs/2b_fs (e^{b_fs C_fs^2} - 1) + kappa/2 (J - 1) ln J,
///
///     I1 = J^{-2/3} tr C,   x_f = max(C_ff - 1, 0),   x_s = max(C_ss - 1, 0):
///
/// fibres and sheets bear tension only. The article's solid is incompressible; here I1 is that of the isochoric part,
/// so that the matrix is free of stress at rest, and fibres feel the whole deformation. With m = a e^{b (I1 - 3)}
/// J^{-2/3}, N = I - tr C/3 C^{-1}, and g(x; a, b) = a x e^{b x^2}:
///
///     S = m N + 2 g(x_f) f x f + 2 g(x_s) s x s + g(C_fs) (f x s + s x f) + J U' C^{-1},   U = kappa/2 (J - 1) ln J.
///
/// The parameters are those of the article's table 1 for simple shear of pig myocardium in six directions.
struct HolzapfelOgden {
  double a = 59, b = 8.023;         ///< [Pa], 1: of the matrix
  double a_f = 18472, b_f = 16.026; ///< of the fibres
  double a_s = 2481, b_s = 11.120;  ///< of the sheets
  double a_fs = 216, b_fs = 11.436; ///< of the shear of one against the other
  double kappa = 50e3;              ///< bulk modulus of the penalty [Pa]

  static constexpr const char *meaning = "orthotropic exponential law of passive myocardium, fibres in tension only";
  void describe(config::Section &s) {
    s.quantity("a", a, "Pa", config::positive, "stiffness of the matrix");
    s.number("b", b, config::positive, "its exponent");
    s.quantity("a_f", a_f, "Pa", config::non_negative, "stiffness of the fibres");
    s.number("b_f", b_f, config::positive, "their exponent");
    s.quantity("a_s", a_s, "Pa", config::non_negative, "stiffness of the sheets");
    s.number("b_s", b_s, config::positive, "their exponent");
    s.quantity("a_fs", a_fs, "Pa", config::non_negative, "stiffness of shear fibre-sheet");
    s.number("b_fs", b_fs, config::positive, "its exponent");
    s.quantity("kappa", kappa, "Pa", config::positive, "bulk modulus");
  }

  template <class T>
  HEARTBUS_INLINE T exponent(const Symmetric<T> &C, const T &J) const {
    const T matrix = b * (isochoric(J) * (C[0] + C[1] + C[2]) - 3.0), x_f = tension(C[0]), x_s = tension(C[1]);
    return larger(larger(matrix, T(b_f * x_f * x_f)), larger(T(b_s * x_s * x_s), T(b_fs * C[3] * C[3])));
  }

  template <class T>
  HEARTBUS_INLINE T energy(const Mat3<T> &F) const {
    const Symmetric<T> C = right_cauchy_green(F);
    const T J = fem::determinant(F), x_f = tension(C[0]), x_s = tension(C[1]);
    return a / (2 * b) * (exp(T(b * (isochoric(J) * (C[0] + C[1] + C[2]) - 3.0))) - 1.0) +
           a_f / (2 * b_f) * (exp(T(b_f * x_f * x_f)) - 1.0) + a_s / (2 * b_s) * (exp(T(b_s * x_s * x_s)) - 1.0) +
           a_fs / (2 * b_fs) * (exp(T(b_fs * C[3] * C[3])) - 1.0) + 0.5 * kappa * (J - 1.0) * log(J);
  }

  template <class T>
  HEARTBUS_INLINE Volumetric<T> volumetric(const T &J) const {
    return {0.5 * kappa * (J * (log(J) + 1.0) - 1.0), 0.5 * kappa * (J + 1.0)};
  }

  template <class T>
  HEARTBUS_INLINE void stress(const Symmetric<T> &C, const T &J, const Volumetric<T> &volumetric,
                              Symmetric<T> &S) const {
    T m, slope;
    matrix_stress(C, isochoric(J), inverse_symmetric(C, J), volumetric, m, S);
    S[0] += 2.0 * exponential(tension(C[0]), a_f, b_f, slope);
    S[1] += 2.0 * exponential(tension(C[1]), a_s, b_s, slope);
    S[3] += exponential(C[3], a_fs, b_fs, slope);
  }

  template <class T>
  HEARTBUS_INLINE void stress_and_tangent(const Symmetric<T> &C, const T &J, const Volumetric<T> &volumetric,
                                          Symmetric<T> &S, Tangent<T> &D) const {
    const Symmetric<T> C_inverse = inverse_symmetric(C, J);
    const T J23 = isochoric(J), trace = C[0] + C[1] + C[2];
    T m, slope;
    matrix_stress(C, J23, C_inverse, volumetric, m, S);
    for (unsigned v = 0; v < 6; ++v)
      for (unsigned w = 0; w < 6; ++w) {
        const double I_v = v < 3 ? 1.0 : 0.0, I_w = w < 3 ? 1.0 : 0.0;
        D[v][w] = 2.0 * b * m * J23 * (I_v - trace / 3.0 * C_inverse[v]) * (I_w - trace / 3.0 * C_inverse[w]) -
                  2.0 / 3.0 * m * (I_v * C_inverse[w] + I_w * C_inverse[v]);
      }
    add_products(C_inverse, T(2.0 / 9.0 * m * trace + volumetric.J_dU + volumetric.J2_ddU),
                 T(2.0 / 3.0 * m * trace - 2.0 * volumetric.J_dU), D);
    S[0] += 2.0 * exponential(tension(C[0]), a_f, b_f, slope);
    D[0][0] += 4.0 * where_stretched(C[0], slope);
    S[1] += 2.0 * exponential(tension(C[1]), a_s, b_s, slope);
    D[1][1] += 4.0 * where_stretched(C[1], slope);
    S[3] += exponential(C[3], a_fs, b_fs, slope);
    D[3][3] += slope; // shared by E_fs and E_sf
  }

 private:
  template <class T>
  HEARTBUS_INLINE static T larger(const T &x, const T &y) {
    return x > y ? x : y;
  }
  template <class T>
  HEARTBUS_INLINE static T tension(const T &I4) {
    return larger(T(I4 - 1.0), T(0.0 * I4));
  }
  /// At rest the tangent is that of tension, or Newton's first step would find next to nothing that resists.
  template <class T>
  HEARTBUS_INLINE static T where_stretched(const T &I4, const T &slope) {
    return I4 >= 1.0 - 1e-12 ? slope : T(0.0 * slope);
  }
  /// J^{-2/3}
  template <class T>
  HEARTBUS_INLINE static T isochoric(const T &J) {
    return exp(T(-2.0 / 3.0 * log(J)));
  }
  /// g(x) = a x e^{b x^2}, and g'(x).
  template <class T>
  HEARTBUS_INLINE static T exponential(const T &x, double a, double b, T &slope) {
    const T stiffness = a * exp(T(b * x * x));
    slope = stiffness * (1.0 + 2.0 * b * x * x);
    return stiffness * x;
  }
  /// S of matrix and volume, and m.
  template <class T>
  HEARTBUS_INLINE void matrix_stress(const Symmetric<T> &C, const T &J23, const Symmetric<T> &C_inverse,
                                     const Volumetric<T> &volumetric, T &m, Symmetric<T> &S) const {
    const T trace = C[0] + C[1] + C[2];
    m = a * exp(T(b * (J23 * trace - 3.0))) * J23;
    for (unsigned v = 0; v < 6; ++v)
      S[v] = v < 3 ? m : T{};
    add_volumetric_stress(C_inverse, T(volumetric.J_dU - m * trace / 3.0), S);
  }
};

} // namespace heartbus::mech
