#include "ep_solver/monodomain_kernel.h"

#include <algorithm>

namespace heartbus::ep {

using fem::Lanes;
using fem::Mat3;
using fem::Vec3;

HEARTBUS_SIMD void monodomain_matrices(unsigned n_q, unsigned n, const double *shapes, const Lanes *gradients,
                                       const Lanes *JxW, const Mat3<Lanes> *D, Lanes *M, Lanes *K) {
  std::fill_n(M, n * n, Lanes{});
  std::fill_n(K, n * n, Lanes{});
  for (unsigned q = 0; q < n_q; ++q) {
    const double *phi = shapes + q * n;
    const Lanes *grad = gradients + q * n * 3;
    for (unsigned b = 0; b < n; ++b) {
      const Vec3<Lanes> flux = D[q] * Vec3<Lanes>{grad[3 * b], grad[3 * b + 1], grad[3 * b + 2]};
      for (unsigned a = 0; a < n; ++a) {
        M[a * n + b] += JxW[q] * (phi[a] * phi[b]);
        K[a * n + b] += JxW[q] * (grad[3 * a] * flux[0] + grad[3 * a + 1] * flux[1] + grad[3 * a + 2] * flux[2]);
      }
    }
  }
}

} // namespace heartbus::ep
