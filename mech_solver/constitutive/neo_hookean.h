#pragma once

#include "mech_solver/constitutive/law.h"

namespace heartbus::mech {

/// Nearly incompressible neo-Hookean solid (Bucelli et al., appendix on constitutive laws: the valve rings):
///
///     W = mu/2 (J^{-2/3} C:I - 3) + kappa/4 ((J - 1)^2 + ln^2 J),
///     S = mu J^{-2/3} (I - I1/3 C^{-1}) + J U' C^{-1},   I1 = C:I.
///
/// It is isotropic: the fibre frame does not matter.
struct NeoHookean {
  double mu = 5e6;    ///< shear modulus [Pa]
  double kappa = 5e6; ///< bulk modulus [Pa]

  static constexpr const char *meaning = "isotropic law";
  void describe(config::Section &s) {
    s.quantity("mu", mu, "Pa", config::positive, "shear modulus");
    s.quantity("kappa", kappa, "Pa", config::positive, "bulk modulus");
  }

  template <class T>
  HEARTBUS_INLINE T exponent(const Symmetric<T> &, const T &) const {
    return T{};
  }

  template <class T>
  HEARTBUS_INLINE T energy(const Mat3<T> &F) const {
    const Symmetric<T> C = right_cauchy_green(F);
    const T J = fem::determinant(F), log_J = log(J);
    return 0.5 * mu * (exp(T(-2.0 / 3.0 * log_J)) * (C[0] + C[1] + C[2]) - 3.0) +
           0.25 * kappa * ((J - 1.0) * (J - 1.0) + log_J * log_J);
  }

  template <class T>
  HEARTBUS_INLINE Volumetric<T> volumetric(const T &J) const {
    const T log_J = log(J);
    return {0.5 * kappa * (J * (J - 1.0) + log_J), 0.5 * kappa * (J * J + 1.0 - log_J)};
  }

  template <class T>
  HEARTBUS_INLINE void stress(const Symmetric<T> &C, const T &J, const Volumetric<T> &volumetric,
                              Symmetric<T> &S) const {
    add_stress(C, isochoric_modulus(J), inverse_symmetric(C, J), volumetric, S);
  }

  template <class T>
  HEARTBUS_INLINE void stress_and_tangent(const Symmetric<T> &C, const T &J, const Volumetric<T> &volumetric,
                                          Symmetric<T> &S, Tangent<T> &D) const {
    const Symmetric<T> C_inverse = inverse_symmetric(C, J);
    const T m = isochoric_modulus(J), I1 = C[0] + C[1] + C[2];
    add_stress(C, m, C_inverse, volumetric, S);
    for (unsigned v = 0; v < 6; ++v)
      for (unsigned w = 0; w < 6; ++w)
        D[v][w] = (-2.0 / 3.0) * m * ((v < 3 ? 1.0 : 0.0) * C_inverse[w] + (w < 3 ? 1.0 : 0.0) * C_inverse[v]);
    add_products(C_inverse, T(2.0 / 9.0 * m * I1 + volumetric.J_dU + volumetric.J2_ddU),
                 T(2.0 / 3.0 * m * I1 - 2.0 * volumetric.J_dU), D);
  }

 private:
  /// mu J^{-2/3}
  template <class T>
  HEARTBUS_INLINE T isochoric_modulus(const T &J) const {
    return mu * exp(T(-2.0 / 3.0 * log(J)));
  }

  template <class T>
  HEARTBUS_INLINE void add_stress(const Symmetric<T> &C, const T &m, const Symmetric<T> &C_inverse,
                                  const Volumetric<T> &volumetric, Symmetric<T> &S) const {
    for (unsigned v = 0; v < 6; ++v)
      S[v] = v < 3 ? m : T{};
    add_volumetric_stress(C_inverse, T(volumetric.J_dU - m * (C[0] + C[1] + C[2]) / 3.0), S);
  }
};

} // namespace heartbus::mech
