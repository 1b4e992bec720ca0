#pragma once

#include "mech_solver/constitutive/law.h"

namespace heartbus::mech {

/// Saint Venant-Kirchhoff: linear in the Green-Lagrange strain E = (C - I)/2, for large rotations and small strains
/// (Turek, Hron 2006, doi:10.1007/3-540-34596-5_15, of their elastic beam):
///
///     W = lambda/2 (tr E)^2 + mu E : E,   S = lambda (tr E) I + 2 mu E,   lambda = kappa - 2/3 mu.
///
/// Without an energy of volume alone: a mean dilatation has nothing to act on. It is isotropic.
struct SaintVenantKirchhoff {
  double mu = 5e5;                ///< shear modulus [Pa]
  double kappa = 2333333.3333333; ///< bulk modulus [Pa]

  static constexpr const char *meaning = "isotropic law, linear in Green's strain";
  void describe(config::Section &s) {
    s.quantity("mu", mu, "Pa", config::positive, "shear modulus");
    s.quantity("kappa", kappa, "Pa", config::positive, "bulk modulus");
  }

  double lambda() const { return kappa - 2.0 / 3.0 * mu; }

  template <class T>
  HEARTBUS_INLINE T exponent(const Symmetric<T> &, const T &) const {
    return T{};
  }

  template <class T>
  HEARTBUS_INLINE T energy(const Mat3<T> &F) const {
    const Symmetric<T> C = right_cauchy_green(F);
    const T trace = 0.5 * (C[0] + C[1] + C[2] - 3.0);
    T square{};
    for (unsigned v = 0; v < 6; ++v) {
      const T E = 0.5 * (v < 3 ? T(C[v] - 1.0) : C[v]);
      square += (v < 3 ? 1.0 : 2.0) * E * E;
    }
    return 0.5 * lambda() * trace * trace + mu * square;
  }

  template <class T>
  HEARTBUS_INLINE Volumetric<T> volumetric(const T &) const {
    return {T{}, T{}};
  }

  template <class T>
  HEARTBUS_INLINE void stress(const Symmetric<T> &C, const T &, const Volumetric<T> &, Symmetric<T> &S) const {
    const T pressure = 0.5 * lambda() * (C[0] + C[1] + C[2] - 3.0);
    for (unsigned v = 0; v < 6; ++v)
      S[v] = v < 3 ? T(pressure + mu * (C[v] - 1.0)) : T(mu * C[v]);
  }

  template <class T>
  HEARTBUS_INLINE void stress_and_tangent(const Symmetric<T> &C, const T &J, const Volumetric<T> &volumetric,
                                          Symmetric<T> &S, Tangent<T> &D) const {
    stress(C, J, volumetric, S);
    const T none = 0.0 * J;
    for (unsigned v = 0; v < 6; ++v)
      for (unsigned w = 0; w < 6; ++w)
        D[v][w] = none + (v < 3 && w < 3 ? lambda() : 0.0) + (v == w ? (v < 3 ? 2.0 : 1.0) * mu : 0.0);
  }
};

} // namespace heartbus::mech
