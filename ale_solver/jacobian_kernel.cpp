#include "ale_solver/jacobian_kernel.h"

#include "common/simd/small_matrix.h"

namespace heartbus::ale {

using fem::Lanes;

HEARTBUS_SIMD void smallest_jacobian(unsigned n, unsigned n_q, const Lanes *gradients, const Lanes *motion,
                                     Lanes &smallest) {
  smallest = fem::lanes(1e300);
  for (unsigned q = 0; q < n_q; ++q) {
    fem::Mat3<Lanes> F = fem::identity<Lanes>();
    for (unsigned a = 0; a < n; ++a)
      for (unsigned i = 0; i < 3; ++i)
        for (unsigned j = 0; j < 3; ++j)
          F[i][j] += motion[3 * a + i] * gradients[(q * n + a) * 3 + j];
    const Lanes J = fem::determinant(F);
    smallest = (smallest > J) | (J != J) ? J : smallest;
  }
}

} // namespace heartbus::ale
