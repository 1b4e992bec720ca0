#pragma once

#include <cmath>

namespace heartbus::fem {

/// Kernels work on this many cells at once: the same arithmetic on each lane. The compiler maps it to whatever vector
/// unit the function is compiled for (see HEARTBUS_SIMD). Four fill a register of AVX2; eight would fill one of
/// AVX-512, but GCC 12 takes vectors to pieces, element by element through memory, where they are wider than the
/// registers.
inline constexpr unsigned n_lanes = 4;
typedef double VectorizedDouble __attribute__((vector_size(n_lanes * sizeof(double))));

/// Put in front of a kernel's entry point: the compiler makes a version for each listed machine and the program picks
/// one when it starts. The levels name instruction sets; a clone for "arch=skylake-avx512" would serve that one
/// processor only. Everything the kernel calls is inlined into it (flatten), else it would run the default version.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define HEARTBUS_SIMD __attribute__((flatten, target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define HEARTBUS_SIMD
#endif
#define HEARTBUS_INLINE inline __attribute__((always_inline))

HEARTBUS_INLINE VectorizedDouble lanes(double value) { return VectorizedDouble{} + value; }

/// Applies a scalar function lane by lane.
template <class Function>
HEARTBUS_INLINE VectorizedDouble by_lane(const VectorizedDouble &x, Function function) {
  VectorizedDouble y;
  for (unsigned i = 0; i < n_lanes; ++i)
    y[i] = function(x[i]);
  return y;
}

} // namespace heartbus::fem
