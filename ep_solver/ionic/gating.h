#pragma once

#include "common/simd/vectorized_math.h"

/// What the equations of several ionic models are written with, for T = double and T = VectorizedDouble.
namespace heartbus::ep {

template <class T>
HEARTBUS_INLINE T square(const T &x) {
  return x * x;
}

template <class T>
HEARTBUS_INLINE T absolute(const T &x) {
  return x < 0.0 ? -x : x;
}

/// Rises from 0 to 1 around `centre`, over a few `slope`s (falls when the slope is negative).
template <class T>
HEARTBUS_INLINE T sigmoid(const T &v, double centre, double slope) {
  using fem::exp;
  return 1.0 / (1.0 + exp((centre - v) * (1 / slope)));
}

/// e^-s for s >= 0 by the Pade approximant (0, 4): positive, falling to 0, right to s^5 / 120.
template <class T>
HEARTBUS_INLINE T decay(const T &s) {
  return 1.0 / (1.0 + s * (1.0 + s * (0.5 + s * (1. / 6 + s * (1. / 24)))));
}

/// dw/dt = (inf - w) / tau.
template <class T>
struct Gate {
  T inf, tau; ///< limit and time constant
};

} // namespace heartbus::ep
