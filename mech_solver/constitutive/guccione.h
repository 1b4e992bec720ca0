#pragma once

#include "mech_solver/constitutive/law.h"

namespace heartbus::mech {

/// Guccione's exponential law of passive myocardium with a volumetric penalty
/// (Guccione, McCulloch, Waldman 1991, doi:10.1115/1.2894084; in this form Bucelli et al., appendix on constitutive
/// laws):
///
///     W = c/2 (e^Q - 1) + kappa/2 (J - 1) ln J,   Q = sum over ordered pairs i, j in {f, s, n} of a_ij E_ij^2,
///
/// with the full Green-Lagrange strain E = (C - I)/2: there is no isochoric split. With A_ij = a_ij E_ij:
///
///     S = c e^Q A + J U' C^{-1},   D = c e^Q (2 A x A + a) + volumetric part,   U = kappa/2 (J - 1) ln J.
///
/// a_fs counts twice in Q, as E_fs^2 + E_sf^2.
struct Guccione {
  double c = 880; ///< [Pa]
  double a_ff = 8, a_ss = 6, a_nn = 3, a_fs = 12, a_fn = 3, a_sn = 3;
  double kappa = 50e3; ///< bulk modulus of the penalty [Pa]

  static constexpr const char *meaning = "transversely anisotropic exponential law of passive myocardium";
  void describe(config::Section &s) {
    s.quantity("c", c, "Pa", config::positive, "stiffness of the exponential");
    s.number("a_ff", a_ff, config::non_negative, "exponent along the fibre");
    s.number("a_ss", a_ss, config::non_negative, "exponent along the sheet");
    s.number("a_nn", a_nn, config::non_negative, "exponent along the sheet normal");
    s.number("a_fs", a_fs, config::non_negative, "exponent of shear fibre-sheet");
    s.number("a_fn", a_fn, config::non_negative, "exponent of shear fibre-normal");
    s.number("a_sn", a_sn, config::non_negative, "exponent of shear sheet-normal");
    s.quantity("kappa", kappa, "Pa", config::positive, "bulk modulus");
  }

  Symmetric<double> coefficients() const { return {a_ff, a_ss, a_nn, a_fs, a_fn, a_sn}; }

  template <class T>
  HEARTBUS_INLINE T exponent(const Symmetric<T> &C, const T &) const {
    Symmetric<T> A;
    return exponent(C, A);
  }

  template <class T>
  HEARTBUS_INLINE T energy(const Mat3<T> &F) const {
    const T J = fem::determinant(F);
    return 0.5 * c * (exp(exponent(right_cauchy_green(F), J)) - 1.0) + 0.5 * kappa * (J - 1.0) * log(J);
  }

  template <class T>
  HEARTBUS_INLINE Volumetric<T> volumetric(const T &J) const {
    return {0.5 * kappa * (J * (log(J) + 1.0) - 1.0), 0.5 * kappa * (J + 1.0)};
  }

  template <class T>
  HEARTBUS_INLINE void stress(const Symmetric<T> &C, const T &J, const Volumetric<T> &volumetric,
                              Symmetric<T> &S) const {
    Symmetric<T> A;
    const T factor = c * exp(exponent(C, A));
    for (unsigned v = 0; v < 6; ++v)
      S[v] = factor * A[v];
    add_volumetric_stress(inverse_symmetric(C, J), volumetric.J_dU, S);
  }

  template <class T>
  HEARTBUS_INLINE void stress_and_tangent(const Symmetric<T> &C, const T &J, const Volumetric<T> &volumetric,
                                          Symmetric<T> &S, Tangent<T> &D) const {
    Symmetric<T> A;
    const T factor = c * exp(exponent(C, A));
    const Symmetric<double> a = coefficients();
    for (unsigned v = 0; v < 6; ++v) {
      S[v] = factor * A[v];
      for (unsigned w = 0; w < 6; ++w)
        D[v][w] = 2.0 * S[v] * A[w];
    }
    for (unsigned v = 0; v < 6; ++v)
      D[v][v] += (v < 3 ? 1.0 : 0.5) * a[v] * factor; // a shear entry is shared by E_ij and E_ji
    const Symmetric<T> C_inverse = inverse_symmetric(C, J);
    add_volumetric_stress(C_inverse, volumetric.J_dU, S);
    add_products(C_inverse, T(volumetric.J_dU + volumetric.J2_ddU), T(-2.0 * volumetric.J_dU), D);
  }

 private:
  /// Q, and A_ij = a_ij E_ij on the way.
  template <class T>
  HEARTBUS_INLINE T exponent(const Symmetric<T> &C, Symmetric<T> &A) const {
    const Symmetric<double> a = coefficients();
    T Q{};
    for (unsigned v = 0; v < 6; ++v) {
      const T E = 0.5 * (v < 3 ? T(C[v] - 1.0) : C[v]);
      A[v] = a[v] * E;
      Q += (v < 3 ? 1.0 : 2.0) * A[v] * E;
    }
    return Q;
  }
};

} // namespace heartbus::mech
