#include "ale_solver/jacobian_kernel.h"

#include "common/simd/small_matrix.h"

namespace heartbus::ale {

using fem::VectorizedDouble;

HEARTBUS_SIMD void smallest_jacobian(unsigned n, unsigned n_q, const VectorizedDouble *gradients,
                                     const VectorizedDouble *ale_displacement, VectorizedDouble &smallest) {
  smallest = fem::lanes(1e300);
  for (unsigned q = 0; q < n_q; ++q) {
    const VectorizedDouble J = fem::determinant(fem::deformation_gradient(
        n, [&](unsigned a, unsigned i) { return ale_displacement[3 * a + i]; }, gradients + q * n * 3));
    smallest = (smallest > J) | (J != J) ? J : smallest;
  }
}

} // namespace heartbus::ale
