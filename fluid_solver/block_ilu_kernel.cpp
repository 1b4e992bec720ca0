#include "fluid_solver/block_ilu_kernel.h"

#include "common/fem/lanes.h"

namespace heartbus::fluid {
namespace {

// Four numbers of a node or of a block's column; aligned like their parts, so that they can lie anywhere in an array.
typedef float Float4 __attribute__((vector_size(16), aligned(4)));
typedef double Double4 __attribute__((vector_size(32), aligned(8)));

/// sum += block k times v
HEARTBUS_INLINE void add_product(const BlockFactors &ilu, int k, const Double4 &v, Double4 &sum) {
  const auto *f = reinterpret_cast<const Float4 *>(ilu.factors + 16 * long(k));
  for (unsigned j = 0; j < 4; ++j)
    sum += __builtin_convertvector(f[j], Double4) * v[j];
}

} // namespace

HEARTBUS_SIMD void solve_block_ilu(const BlockFactors &ilu, const double *x, double *y) {
  const auto *x_blocks = reinterpret_cast<const Double4 *>(x);
  auto *y_blocks = reinterpret_cast<Double4 *>(y);
  for (int i = 0; i < ilu.n_rows; ++i) {
    Double4 sum{};
    for (int k = ilu.begin[i]; k < ilu.diagonal[i]; ++k)
      add_product(ilu, k, y_blocks[ilu.columns[k]], sum);
    y_blocks[i] = x_blocks[i] - sum;
  }
  for (int i = ilu.n_rows - 1; i >= 0; --i) {
    Double4 sum{}, solution{};
    for (int k = ilu.diagonal[i] + 1; k < ilu.begin[i + 1]; ++k)
      add_product(ilu, k, y_blocks[ilu.columns[k]], sum);
    add_product(ilu, ilu.diagonal[i], y_blocks[i] - sum, solution);
    y_blocks[i] = solution;
  }
}

} // namespace heartbus::fluid
