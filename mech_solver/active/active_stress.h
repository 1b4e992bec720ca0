#pragma once

#include "mech_solver/constitutive/law.h"

namespace heartbus::mech {

/// Active stress along the fibres (Bucelli et al. 2023, section 2.4, doi:10.1016/j.jcp.2023.112326; Regazzoni et al.
/// 2022, doi:10.1016/j.jcp.2022.111083):
///
///     P_act = T F f0 x f0 / sqrt(I4f),  I4f = |F f0|^2,   i.e.  S_act = T / sqrt(I4f) f0 x f0,
///
/// so T is the nominal stress in the fibre direction. Of dispersed fibres a share nu lies along n0 (fem::Fibres):
///
///     S_act = T [(1 - nu) f0 x f0 / sqrt(I4f) + nu n0 x n0 / sqrt(I4n)],   I4 = (1 - nu) I4f + nu I4n.
///
/// In the fibre frame f0 is the first axis, n0 the third, I4f = C_ff, I4n = C_nn. T does not depend on the unknown
/// deformation: the force model saw the stretch of the last step.
template <class T>
HEARTBUS_INLINE T fibre_stretch_squared(const T &nu, const Symmetric<T> &C) {
  return C[0] + nu * (C[2] - C[0]);
}

template <class T>
HEARTBUS_INLINE void add_active_stress(const T &tension, const T &nu, const Symmetric<T> &C, Symmetric<T> &S) {
  S[0] += (1.0 - nu) * tension / sqrt(C[0]);
  S[2] += nu * tension / sqrt(C[2]);
}

/// dS_ff/dE_ff = -T (1 - nu) I4f^{-3/2}, dS_nn/dE_nn likewise.
template <class T>
HEARTBUS_INLINE void add_active_stress(const T &tension, const T &nu, const Symmetric<T> &C, Symmetric<T> &S,
                                       Tangent<T> &D) {
  const T f = (1.0 - nu) * tension / sqrt(C[0]), n = nu * tension / sqrt(C[2]);
  S[0] += f;
  S[2] += n;
  D[0][0] -= f / C[0];
  D[2][2] -= n / C[2];
}

} // namespace heartbus::mech
