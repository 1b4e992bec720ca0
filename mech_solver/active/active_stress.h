#pragma once

#include "mech_solver/constitutive/law.h"

namespace heartbus::mech {

/// Active stress along the fibres (Bucelli et al. 2023, section 2.4, doi:10.1016/j.jcp.2023.112326; Regazzoni et al.
/// 2022, doi:10.1016/j.jcp.2022.111083):
///
///     P_act = T F f0 x f0 / sqrt(I4f),  I4f = |F f0|^2,   i.e.  S_act = T / sqrt(I4f) f0 x f0,
///
/// so T is the nominal stress in the fibre direction. Of dispersed fibres a share nu lies along n0 (fem::Fibres), and
/// fibres shorter than the force model knows pull less, by `overlap` O:
///
///     S_act = T O(SL) / lambda H,   H = (1 - nu) f0 x f0 + nu n0 x n0,   lambda^2 = I4 = H : C,   SL = SL0 lambda.
///
/// In the fibre frame f0 is the first axis and n0 the third. T does not depend on the unknown deformation: the force
/// model saw the stretch of the last step. O does, so that what it takes away is as stable as a passive stress.
///
/// Where T is prescribed it is what the scene says it is: the nominal stress, O = 1, or the second Piola-Kirchhoff
/// stress, S_act = T H (Land et al. 2015, doi:10.1098/rspa.2015.0641, problem 3).
struct ActiveFibres {
  double sarcomere_length = 2.2; ///< SL0, at rest [um]
  enum class Tension { of_force_model, nominal, second_piola } tension = Tension::of_force_model;
};

/// Share of the cross-bridges that still have actin of one polarity to bind to in sarcomeres shorter than 1.7 um, where
/// the networks of the RDQ18 model were trained no further, relative to 1.7 um. It is the single overlap of that
/// model's own filaments (Regazzoni, Dede', Quarteroni 2018, doi:10.1007/s10237-018-1049-0; actin L_A = 1.2, myosin L_M
/// = 1.65, bare zone L_B = 0.1 um),
///
///     chi(SL) = 2 (SL - L_A) / (L_M - L_B)  from L_A to L_M,   (SL + L_M - 2 L_A) / (L_M - L_B)  from there on,
///
/// O = chi(SL) / chi(1.7) between 0 and 1. `slope` is dO/dSL [1/um].
template <class T>
HEARTBUS_INLINE T overlap(const T &SL, T &slope) {
  constexpr double L_A = 1.2, L_M = 1.65, shortest = 1.7, full = shortest + L_M - 2 * L_A;
  const T none = 0.0 * SL, one = none + 1.0;
  slope = SL < L_A ? none : SL < L_M ? none + 2 / full : SL < shortest ? none + 1 / full : none;
  return SL < L_A        ? none
         : SL < L_M      ? T(2 / full * (SL - L_A))
         : SL < shortest ? T(1 / full * (SL + L_M - 2 * L_A))
                         : one;
}

template <class T>
HEARTBUS_INLINE T fibre_stretch_squared(const T &nu, const Symmetric<T> &C) {
  return C[0] + nu * (C[2] - C[0]);
}

/// sigma and sigma' of S_act = sigma H, D = sigma' H x H: T O / lambda and T (SL0 O' - O / lambda) / lambda^2.
template <class T>
HEARTBUS_INLINE T fibre_stress(const T &tension, const T &I4, const ActiveFibres &fibres, T &modulus) {
  modulus = 0.0 * I4;
  if (fibres.tension == ActiveFibres::Tension::second_piola)
    return tension;
  const T lambda = sqrt(I4);
  T slope = modulus, O = modulus + 1.0;
  if (fibres.tension == ActiveFibres::Tension::of_force_model)
    O = overlap(T(fibres.sarcomere_length * lambda), slope);
  modulus = tension * (fibres.sarcomere_length * slope - O / lambda) / I4;
  return tension * O / lambda;
}

template <class T>
HEARTBUS_INLINE void add_active_stress(const T &tension, const T &nu, const ActiveFibres &fibres, const Symmetric<T> &C,
                                       Symmetric<T> &S) {
  T modulus;
  const T stress = fibre_stress(tension, fibre_stretch_squared(nu, C), fibres, modulus);
  S[0] += (1.0 - nu) * stress;
  S[2] += nu * stress;
}

template <class T>
HEARTBUS_INLINE void add_active_stress(const T &tension, const T &nu, const ActiveFibres &fibres, const Symmetric<T> &C,
                                       Symmetric<T> &S, Tangent<T> &D) {
  T modulus;
  const T stress = fibre_stress(tension, fibre_stretch_squared(nu, C), fibres, modulus), f = T(1.0 - nu);
  S[0] += f * stress;
  S[2] += nu * stress;
  D[0][0] += f * f * modulus;
  D[2][2] += nu * nu * modulus;
  D[0][2] += f * nu * modulus;
  D[2][0] += f * nu * modulus;
}

} // namespace heartbus::mech
