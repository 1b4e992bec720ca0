#pragma once

#include "common/simd/vectorized_double.h"

#include <cmath>
#include <cstdint>
#include <limits>

namespace heartbus::fem {

/// Elementary functions for `double` (the standard library's) and for `VectorizedDouble` (below), under the same
/// names, so that a pointwise model is written once. The vector versions agree with the standard library to a few units
/// in the last place; tests/unit/vectorized_math.cpp measures it.
namespace vectorized_math {

typedef std::int64_t Integers __attribute__((vector_size(n_lanes * sizeof(std::int64_t))));

HEARTBUS_INLINE Integers bits(const VectorizedDouble &x) {
  Integers i;
  __builtin_memcpy(&i, &x, sizeof(i));
  return i;
}

HEARTBUS_INLINE VectorizedDouble from_bits(const Integers &i) {
  VectorizedDouble x;
  __builtin_memcpy(&x, &i, sizeof(x));
  return x;
}

/// Polynomial of x, coefficients from the highest power to the constant.
template <class... Coefficients>
HEARTBUS_INLINE VectorizedDouble horner(const VectorizedDouble &x, Coefficients... coefficients) {
  VectorizedDouble p{};
  ((p = p * x + coefficients), ...);
  return p;
}

/// Adding it rounds to an integer, which then stands in the low bits.
inline constexpr double rounding = 0x1.8p52;

HEARTBUS_INLINE VectorizedDouble clamp(VectorizedDouble x, double limit) {
  x = x < -limit ? lanes(-limit) : x;
  return x > limit ? lanes(limit) : x;
}

/// x = n log(2) + r with |r| <= log(2)/2.
struct Reduced {
  VectorizedDouble r, two_to_n;
};
HEARTBUS_INLINE Reduced reduce(const VectorizedDouble &x) {
  const VectorizedDouble shifted = x * 0x1.71547652b82fep0 + rounding; // log2(e)
  const VectorizedDouble n = shifted - rounding;
  return {(x - n * 0x1.62e42fefa3800p-1) - n * 0x1.ef35793c76730p-45, // log(2) in two parts
          from_bits((bits(shifted) + 1023) << 52)};
}

/// e^x = 2^n e^r, e^r by its Taylor polynomial of degree 12. x is cut to +-708, where doubles end.
HEARTBUS_INLINE VectorizedDouble exp(const VectorizedDouble &x) {
  const auto [r, two_to_n] = reduce(clamp(x, 708));
  return two_to_n * horner(r, 1. / 479001600, 1. / 39916800, 1. / 3628800, 1. / 362880, 1. / 40320, 1. / 5040, 1. / 720,
                           1. / 120, 1. / 24, 1. / 6, 1. / 2, 1., 1.);
}

/// tanh x = a / (a + 2), a = e^2x - 1 = 2^n (e^r - 1) + (2^n - 1), which loses nothing near 0; from |x| = 20 on it is
/// +-1.
HEARTBUS_INLINE VectorizedDouble tanh(const VectorizedDouble &x) {
  const auto [r, two_to_n] = reduce(2.0 * clamp(x, 20));
  const VectorizedDouble a =
      two_to_n * (r * horner(r, 1. / 479001600, 1. / 39916800, 1. / 3628800, 1. / 362880, 1. / 40320, 1. / 5040,
                             1. / 720, 1. / 120, 1. / 24, 1. / 6, 1. / 2, 1.)) +
      (two_to_n - 1.0);
  return a / (a + 2.0);
}

/// log x = n log 2 + log m with m in [0.7, 1.4], log m = 2 artanh((m-1)/(m+1)). NaN unless x > 0.
HEARTBUS_INLINE VectorizedDouble log(const VectorizedDouble &x) {
  const Integers sqrt_half = bits(lanes(0x1.6a09e667f3bcdp-1));
  const Integers n = (bits(x) - sqrt_half) >> 52;
  const VectorizedDouble m = from_bits(bits(x) - (n << 52));
  const VectorizedDouble n_real = from_bits(n + bits(lanes(rounding))) - rounding;
  const VectorizedDouble s = (m - 1.0) / (m + 1.0), s2 = s * s;
  const VectorizedDouble p =
      horner(s2, 1. / 21, 1. / 19, 1. / 17, 1. / 15, 1. / 13, 1. / 11, 1. / 9, 1. / 7, 1. / 5, 1. / 3, 1.);
  const VectorizedDouble result = n_real * 0x1.62e42fefa3800p-1 + (2.0 * s * p + n_real * 0x1.ef35793c76730p-45);
  return x > 0.0 ? result : lanes(std::numeric_limits<double>::quiet_NaN());
}

HEARTBUS_INLINE VectorizedDouble sqrt(const VectorizedDouble &x) {
  return by_lane(x, [](double lane) { return std::sqrt(lane); });
}

} // namespace vectorized_math

using std::exp;
using std::log;
using std::sqrt;
using std::tanh;
using vectorized_math::exp;
using vectorized_math::log;
using vectorized_math::sqrt;
using vectorized_math::tanh;

} // namespace heartbus::fem
