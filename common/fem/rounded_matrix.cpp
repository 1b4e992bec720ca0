#include "common/fem/rounded_matrix.h"

#include "common/fem/block_product_kernel.h"

namespace heartbus::fem {

RoundedMatrix::RoundedMatrix(const NodalMatrix &matrix)
    : components_(matrix.components()), n_nodes_(matrix.n_rows() / int(components_)), begin_{0} {
  const int c = int(components_), *row_begin = matrix.row_begin();
  columns_.assign(matrix.column_nodes(), matrix.column_nodes() + row_begin[matrix.n_rows()] / (c * c));
  values_.reserve(row_begin[matrix.n_rows()] + 1);
  for (int row = 0; row < matrix.n_rows(); row += c) {
    for (int k = 0; k < row_begin[row + 1] - row_begin[row]; k += c)
      for (int j = 0; j < c; ++j)
        for (int i = 0; i < c; ++i)
          values_.push_back(float(matrix.values()[row_begin[row + i] + k + j]));
    begin_.push_back(int(values_.size()) / (c * c));
  }
  values_.push_back(0); // loaded with the last block
  if (c == 3)
    fours_.resize(4 * std::size_t(matrix.space().n_local_nodes()));
}

void RoundedMatrix::vmult(Vector &y, const Vector &x) const {
  const GhostValues ghosts(x);
  const double *values = x.begin();
  for (std::size_t node = 0; node < fours_.size() / 4; ++node)
    for (unsigned i = 0; i < 3; ++i)
      fours_[4 * node + i] = values[3 * node + i];
  multiply_rounded({components_, n_nodes_, begin_.data(), columns_.data(), values_.data()},
                   fours_.empty() ? values : fours_.data(), y.begin());
}

} // namespace heartbus::fem
