#include "common/linear_algebra/block_ilu_kernel.h"

#include "common/linear_algebra/block_products.h"
#include "common/simd/sparse_dot.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace heartbus::fem {
namespace {

template <unsigned b>
HEARTBUS_INLINE Double4 products(const BlockFactors &ilu, int first, int last, const double *z) {
  return block_products<b>(ilu.factors, ilu.columns, first, last, z);
}

template <unsigned b>
HEARTBUS_INLINE Double4 load(const double *x) {
  Double4 v{};
  for (unsigned i = 0; i < b; ++i)
    v[i] = x[i];
  return v;
}

/// Where the right-hand side of a row is.
HEARTBUS_INLINE int source_of(const BlockFactors &ilu, int n_ghosts, int i) {
  return i < n_ghosts ? ilu.n_rows - n_ghosts + i : i - n_ghosts;
}

template <unsigned b>
HEARTBUS_INLINE void solve(const BlockFactors &ilu, int n_ghosts, const double *x, double *y, double *z) {
  int first = 0;
  for (int i = 0; i < ilu.n_rows; first = ilu.end[i++])
    store4(z + 4 * i, load<b>(x + b * source_of(ilu, n_ghosts, i)) - products<b>(ilu, first, ilu.end[i], z));
  for (int row = ilu.n_rows; row < 2 * ilu.n_rows - n_ghosts; first = ilu.end[row++]) {
    const int i = 2 * ilu.n_rows - 1 - row, diagonal = ilu.end[row] - 1;
    store4(z + 4 * i, load4(z + 4 * i) - products<b>(ilu, first, diagonal, z));
    const Double4 solution = products<b>(ilu, diagonal, diagonal + 1, z);
    store4(z + 4 * i, solution);
    for (unsigned j = 0; j < b; ++j)
      y[b * (i - n_ghosts) + j] = solution[j];
  }
}

template <>
HEARTBUS_INLINE void solve<1>(const BlockFactors &ilu, int n_ghosts, const double *x, double *y, double *z) {
  const auto products = [&](int first, int last) {
    return sparse_dot(ilu.factors + first, ilu.columns + first, last - first, z);
  };
  int first = 0;
  for (int i = 0; i < ilu.n_rows; first = ilu.end[i++])
    z[i] = x[source_of(ilu, n_ghosts, i)] - products(first, ilu.end[i]);
  for (int row = ilu.n_rows; row < 2 * ilu.n_rows - n_ghosts; first = ilu.end[row++]) {
    const int i = 2 * ilu.n_rows - 1 - row, diagonal = ilu.end[row] - 1;
    y[i - n_ghosts] = z[i] = ilu.factors[diagonal] * (z[i] - products(first, diagonal));
  }
}

} // namespace

namespace {

/// A column of a block; of three components, the fourth number is never used.
template <unsigned b>
struct ColumnOf {
  using Type = Double4;
};
template <>
struct ColumnOf<1> {
  using Type = double;
};
template <unsigned b>
using Column = typename ColumnOf<b>::Type;

HEARTBUS_INLINE void load_column(double &column, const float *x) { column = *x; }
HEARTBUS_INLINE void load_column(Double4 &column, const float *x) { column = load4(x); }

HEARTBUS_INLINE double entry(double column, unsigned) { return column; }
HEARTBUS_INLINE double entry(Double4 column, unsigned i) { return column[i]; }

template <unsigned b>
HEARTBUS_INLINE void store_block(const Column<b> *block, float *values) {
  for (unsigned j = 0; j < b; ++j)
    for (unsigned i = 0; i < b; ++i)
      values[b * j + i] = float(entry(block[j], i));
}

/// Column j of the product of a block and one in memory.
template <unsigned b>
HEARTBUS_INLINE Column<b> product_column(const Column<b> *block, const float *other, unsigned j) {
  Column<b> sum = block[0] * double(other[b * j]);
  for (unsigned k = 1; k < b; ++k)
    sum += block[k] * double(other[b * j + k]);
  return sum;
}

/// Gauss-Jordan in the order of the components, each of whose pivots is positive in a stabilised problem.
template <unsigned b>
HEARTBUS_INLINE bool invert(const Column<b> *block, float *values) {
  double a[b][b];
  for (unsigned j = 0; j < b; ++j)
    for (unsigned i = 0; i < b; ++i)
      a[i][j] = entry(block[j], i);
  bool finite = true;
  for (unsigned k = 0; k < b; ++k) {
    const double pivot = 1 / a[k][k];
    finite &= std::abs(pivot) < 1e300; // false for NaN, too
    a[k][k] = 1;
    for (unsigned j = 0; j < b; ++j)
      a[k][j] *= pivot;
    for (unsigned i = 0; i < b; ++i)
      if (i != k) {
        const double factor = a[i][k];
        a[i][k] = 0;
        for (unsigned j = 0; j < b; ++j)
          a[i][j] -= factor * a[k][j];
      }
  }
  for (unsigned j = 0; j < b; ++j)
    for (unsigned i = 0; i < b; ++i)
      values[b * j + i] = float(a[i][j]);
  return finite;
}

/// Row by row, each from the rows of U above it; the row in hand is in double precision.
template <unsigned b>
HEARTBUS_INLINE bool factorise(const RowsWithGhosts &rows, const BlockFactors &ilu, float *values) {
  constexpr long size = b * b;
  const int n = ilu.n_rows;
  const auto upper = [&](int i) { return ilu.end[2 * n - 2 - i]; }; // where row i of U starts
  std::vector<int> place(n, -1);                                    // of the blocks of the row in hand, by column
  std::vector<Column<b>> row;
  bool finite = true;
  for (int i = 0; i < n; ++i) {
    const int *columns = rows.columns + rows.begin[i], length = rows.begin[i + 1] - rows.begin[i];
    const float *source = i < rows.n_ghosts ? rows.ghosts : rows.owned;
    row.resize(std::max<std::size_t>(row.size(), b * length));
    for (int k = 0; k < length; ++k) {
      place[columns[k]] = k;
      for (unsigned j = 0; j < b; ++j)
        load_column(row[b * k + j], source + size * rows.sources[rows.begin[i] + k] + b * j);
    }
    float *lower = values + size * (i == 0 ? 0 : ilu.end[i - 1]);
    int k = 0;
    for (; columns[k] < i; ++k, lower += size) {
      const int first = upper(columns[k]), diagonal = ilu.end[2 * n - 1 - columns[k]] - 1;
      Column<b> L[b];
      for (unsigned j = 0; j < b; ++j)
        L[j] = product_column<b>(&row[b * k], values + size * diagonal, j);
      store_block<b>(L, lower);
      for (int u = first; u < diagonal; ++u)
        if (const int target = place[ilu.columns[u]]; target >= 0)
          for (unsigned j = 0; j < b; ++j)
            row[b * target + j] -= product_column<b>(L, values + size * u, j);
    }
    const int diagonal = k;
    float *above = values + size * upper(i);
    for (++k; k < length; ++k, above += size)
      store_block<b>(&row[b * k], above);
    finite &= invert<b>(&row[b * diagonal], above);
    for (int k = 0; k < length; ++k)
      place[columns[k]] = -1;
  }
  return finite;
}

} // namespace

HEARTBUS_SIMD bool factorise_blocks(const RowsWithGhosts &rows, const BlockFactors &factors, float *values) {
  switch (factors.b) {
  case 1:
    return factorise<1>(rows, factors, values);
  case 3:
    return factorise<3>(rows, factors, values);
  default:
    return factorise<4>(rows, factors, values);
  }
}

HEARTBUS_SIMD void solve_block_ilu(const BlockFactors &ilu, int n_ghosts, const double *x, double *y, double *work) {
  switch (ilu.b) {
  case 1:
    return solve<1>(ilu, n_ghosts, x, y, work);
  case 3:
    return solve<3>(ilu, n_ghosts, x, y, work);
  default:
    return solve<4>(ilu, n_ghosts, x, y, work);
  }
}

HEARTBUS_SIMD void solve_ilu_3rhs(const BlockFactors &ilu, int n_ghosts, const double *x, double *y, double *z) {
  const auto products = [&](int first, int last) {
    return sparse_dot_of_fours(ilu.factors + first, ilu.columns + first, last - first, z);
  };
  int first = 0;
  for (int i = 0; i < ilu.n_rows; first = ilu.end[i++])
    store4(z + 4 * i, load<3>(x + 3 * source_of(ilu, n_ghosts, i)) - products(first, ilu.end[i]));
  for (int row = ilu.n_rows; row < 2 * ilu.n_rows - n_ghosts; first = ilu.end[row++]) {
    const int i = 2 * ilu.n_rows - 1 - row, diagonal = ilu.end[row] - 1;
    const Double4 solution = double(ilu.factors[diagonal]) * (load4(z + 4 * i) - products(first, diagonal));
    store4(z + 4 * i, solution);
    for (unsigned c = 0; c < 3; ++c)
      y[3 * (i - n_ghosts) + c] = solution[c];
  }
}

} // namespace heartbus::fem
