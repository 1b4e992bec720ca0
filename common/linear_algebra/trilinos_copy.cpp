#include "common/linear_algebra/trilinos_copy.h"

#include <Epetra_Map.h>
#include <Epetra_MpiComm.h>

#include <algorithm>

namespace heartbus::fem {

namespace {

/// Calls action(row, length, values, columns) with the numbers of rows and columns on this rank.
template <class Action>
void visit_rows(const BlockMatrix<double> &matrix, const Action &action) {
  const int c = int(matrix.components());
  const BlockPattern &pattern = *matrix.pattern();
  std::vector<double> values;
  std::vector<int> columns;
  for (int row = 0; row < c * pattern.n_rows(); ++row) {
    values.clear();
    columns.clear();
    for (int block = pattern.begin()[row / c]; block < pattern.begin()[row / c + 1]; ++block)
      for (int j = 0; j < c; ++j) {
        values.push_back(matrix.values()[(std::size_t(block) * c + j) * c + row % c]);
        columns.push_back(pattern.columns()[block] * c + j);
      }
    action(row, int(values.size()), values.data(), columns.data());
  }
}

} // namespace

std::unique_ptr<Epetra_CrsMatrix> trilinos_copy(const BlockMatrix<double> &matrix) {
  const LagrangeSpace &space = matrix.space();
  const int c = int(matrix.components()), n_columns = c * int(space.n_local_nodes());
  std::vector<int> numbers;
  for (int k = 0; k < n_columns; ++k)
    numbers.push_back(int(space.global_node(k / c)) * c + k % c);
  std::vector<int> lengths;
  visit_rows(matrix, [&](int, int length, auto...) { lengths.push_back(length); });
  const Epetra_MpiComm communicator(space.communicator());
  const Epetra_Map rows(-1, int(matrix.n_rows()), 0, communicator),
      columns(-1, n_columns, numbers.data(), 0, communicator);
  auto copy = std::make_unique<Epetra_CrsMatrix>(Copy, rows, columns, lengths.data(), true);
  visit_rows(matrix, [&](int row, int length, double *values, int *columns) {
    copy->InsertMyValues(row, length, values, columns);
  });
  copy->FillComplete(rows, rows);
  return copy;
}

void copy_values(const BlockMatrix<double> &matrix, Epetra_CrsMatrix &copy) {
  visit_rows(matrix, [&](int row, int length, double *values, int *) { // columns are sorted here and there
    double *there = nullptr;
    copy.ExtractMyRowView(row, length, there);
    std::copy_n(values, length, there);
  });
}

} // namespace heartbus::fem
