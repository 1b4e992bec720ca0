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

  template <class T>
  HEARTBUS_INLINE T exponent(const Symmetric<T> &) const {
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
  HEARTBUS_INLINE void stress(const Symmetric<T> &C, const T &J, Symmetric<T> &S) const {
    const T log_J = log(J);
    add_stress(C, J, log_J, inverse_symmetric(C, J), S);
  }

  template <class T>
  HEARTBUS_INLINE void stress_and_tangent(const Symmetric<T> &C, const T &J, Symmetric<T> &S, Tangent<T> &D) const {
    const T log_J = log(J);
    const Symmetric<T> C_inverse = inverse_symmetric(C, J);
    add_stress(C, J, log_J, C_inverse, S);

    const T m = mu * exp(T(-2.0 / 3.0 * log_J)), I1 = C[0] + C[1] + C[2];
    for (unsigned v = 0; v < 6; ++v)
      for (unsigned w = 0; w < 6; ++w)
        D[v][w] = (-2.0 / 3.0) * m * ((v < 3 ? 1.0 : 0.0) * C_inverse[w] + (w < 3 ? 1.0 : 0.0) * C_inverse[v]);
    const T J2_ddU = 0.5 * kappa * (J * J + 1.0 - log_J), J_dU = 0.5 * kappa * (J * (J - 1.0) + log_J);
    add_products(C_inverse, T(2.0 / 9.0 * m * I1 + J_dU + J2_ddU), T(2.0 / 3.0 * m * I1 - 2.0 * J_dU), D);
  }

 private:
  template <class T>
  HEARTBUS_INLINE void add_stress(const Symmetric<T> &C, const T &J, const T &log_J, const Symmetric<T> &C_inverse,
                                  Symmetric<T> &S) const {
    const T m = mu * exp(T(-2.0 / 3.0 * log_J)), I1 = C[0] + C[1] + C[2];
    for (unsigned v = 0; v < 6; ++v)
      S[v] = v < 3 ? m : T{};
    const T J_dU = 0.5 * kappa * (J * (J - 1.0) + log_J);
    add_volumetric_stress(C_inverse, T(J_dU - m * I1 / 3.0), S);
  }
};

} // namespace heartbus::mech
