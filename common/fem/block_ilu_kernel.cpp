#include "common/fem/block_ilu_kernel.h"

#include "common/fem/lanes.h"

namespace heartbus::fem {
namespace {

// Four numbers of a node or of a block's column; aligned like their parts, so that they can lie anywhere in an array.
typedef float Float4 __attribute__((vector_size(16), aligned(4)));
typedef double Double4 __attribute__((vector_size(32), aligned(8)));

/// What belongs to a node of b components, in a register.
template <unsigned b>
struct Node {
  Double4 values{};

  HEARTBUS_INLINE static Node load(const double *x) {
    Node node;
    for (unsigned i = 0; i < b; ++i)
      node.values[i] = x[i];
    return node;
  }
  /// *this += block times v
  HEARTBUS_INLINE void add_product(const float *block, const Node &v) {
    const auto *columns = reinterpret_cast<const Float4 *>(block);
    for (unsigned j = 0; j < b; ++j)
      values += __builtin_convertvector(columns[j], Double4) * v.values[j];
  }
  HEARTBUS_INLINE void store(double *y) const {
    for (unsigned i = 0; i < b; ++i)
      y[i] = values[i];
  }
  HEARTBUS_INLINE void subtract_from(const Node &v) { values = v.values - values; }
};

template <>
struct Node<1> {
  double value = 0;

  HEARTBUS_INLINE static Node load(const double *x) { return {*x}; }
  HEARTBUS_INLINE void add_product(const float *block, const Node &v) { value += *block * v.value; }
  HEARTBUS_INLINE void store(double *y) const { *y = value; }
  HEARTBUS_INLINE void subtract_from(const Node &v) { value = v.value - value; }
};

template <unsigned b>
HEARTBUS_INLINE void solve(const BlockFactors &ilu, const double *x, double *y, double *work) {
  constexpr unsigned block_size = b * column_length(b);
  auto *z = reinterpret_cast<Node<b> *>(work);
  const auto add_products = [&](int first, int last, Node<b> &sum) {
    for (int k = first; k < last; ++k)
      sum.add_product(ilu.factors + long(block_size) * k, z[ilu.columns[k]]);
  };
  for (int i = 0; i < ilu.n_rows; ++i) {
    Node<b> sum;
    add_products(ilu.begin[i], ilu.diagonal[i], sum);
    sum.subtract_from(Node<b>::load(x + b * i));
    z[i] = sum;
  }
  for (int i = ilu.n_rows - 1; i >= 0; --i) {
    Node<b> sum, solution;
    add_products(ilu.diagonal[i] + 1, ilu.begin[i + 1], sum);
    sum.subtract_from(z[i]);
    solution.add_product(ilu.factors + long(block_size) * ilu.diagonal[i], sum);
    z[i] = solution;
    solution.store(y + b * i);
  }
}

} // namespace

HEARTBUS_SIMD void solve_block_ilu(const BlockFactors &ilu, const double *x, double *y, double *work) {
  switch (ilu.b) {
  case 1:
    return solve<1>(ilu, x, y, work);
  case 3:
    return solve<3>(ilu, x, y, work);
  default:
    return solve<4>(ilu, x, y, work);
  }
}

} // namespace heartbus::fem
