#include "ep_solver/monodomain_kernel.h"

#include <algorithm>
#include <cstring>

namespace heartbus::ep {

using fem::Mat3;
using fem::Vec3;
using fem::VectorizedDouble;

namespace {

typedef double Double2 __attribute__((vector_size(16)));

HEARTBUS_INLINE Double2 load2(const double *x) {
  Double2 v;
  std::memcpy(&v, x, sizeof v);
  return v;
}

HEARTBUS_INLINE Double2 load2(const float *x) {
  typedef float Float2 __attribute__((vector_size(8)));
  Float2 v;
  std::memcpy(&v, x, sizeof v);
  return __builtin_convertvector(v, Double2);
}

} // namespace

HEARTBUS_SIMD void monodomain_matrices(unsigned n_q, unsigned n, const double *shapes,
                                       const VectorizedDouble *gradients, const VectorizedDouble *JxW,
                                       const Mat3<VectorizedDouble> *D, VectorizedDouble *M, VectorizedDouble *K) {
  std::fill_n(M, n * n, VectorizedDouble{});
  std::fill_n(K, n * n, VectorizedDouble{});
  for (unsigned q = 0; q < n_q; ++q) {
    const double *phi = shapes + q * n;
    const VectorizedDouble *grad = gradients + q * n * 3;
    for (unsigned b = 0; b < n; ++b) {
      const Vec3<VectorizedDouble> flux = D[q] * Vec3<VectorizedDouble>{grad[3 * b], grad[3 * b + 1], grad[3 * b + 2]};
      for (unsigned a = 0; a < n; ++a) {
        M[a * n + b] += JxW[q] * (phi[a] * phi[b]);
        K[a * n + b] += JxW[q] * (grad[3 * a] * flux[0] + grad[3 * a + 1] * flux[1] + grad[3 * a + 2] * flux[2]);
      }
    }
  }
}

HEARTBUS_SIMD void subtract_flux(int n_rows, const int *begin, const int *columns, const float *entries,
                                 const double *wv, double *r) {
  for (int row = 0; row < n_rows; ++row) {
    Double2 sums[4] = {}; // a single one would wait for each addition to end
    int k = begin[row];
    for (; k + 4 <= begin[row + 1]; k += 4)
      for (int i = 0; i < 4; ++i)
        sums[i] += load2(entries + 2 * (k + i)) * load2(wv + 2 * columns[k + i]);
    for (; k < begin[row + 1]; ++k)
      sums[0] += load2(entries + 2 * k) * load2(wv + 2 * columns[k]);
    const Double2 sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
    r[row] = sum[0] + sum[1];
  }
}

} // namespace heartbus::ep
