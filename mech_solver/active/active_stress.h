#pragma once

#include "mech_solver/constitutive/law.h"

namespace heartbus::mech {

/// Active stress along the fibre f0 (Bucelli et al., section on solid mechanics; Regazzoni et al. 2022,
/// doi:10.1016/j.jcp.2022.111083):
///
///     P_act = T F f0 x f0 / sqrt(I4f),  I4f = |F f0|^2,   i.e.  S_act = T / sqrt(I4f) f0 x f0,
///
/// so T is the nominal stress in the fibre direction. In the fibre frame f0 is the first axis and I4f = C_ff. T does
/// not depend on the unknown deformation: the force model saw the stretch of the last step.
template <class T>
HEARTBUS_INLINE T fibre_stretch_squared(const Symmetric<T> &C) {
  return C[0];
}

template <class T>
HEARTBUS_INLINE T active_stress_ff(const T &tension, const Symmetric<T> &C) {
  return tension / sqrt(fibre_stretch_squared(C));
}

/// dS_ff/dE_ff = -T I4f^{-3/2}.
template <class T>
HEARTBUS_INLINE void add_active_stress(const T &tension, const Symmetric<T> &C, Symmetric<T> &S, Tangent<T> &D) {
  const T s = active_stress_ff(tension, C);
  S[0] += s;
  D[0][0] -= s / fibre_stretch_squared(C);
}

} // namespace heartbus::mech
