#include "fluid_solver/block_preconditioner.h"

#include <deal.II/lac/trilinos_precondition.h>

#include <EpetraExt_MatrixMatrix.h>
#include <Epetra_CrsMatrix.h>
#include <Epetra_Map.h>
#include <Epetra_MpiComm.h>
#include <Epetra_Vector.h>

namespace heartbus::fluid {
namespace {

/// The entries of one block's row, as Epetra wants them.
struct Row {
  std::vector<int> columns;
  std::vector<double> values;
  void add(int column, double value) {
    columns.push_back(column);
    values.push_back(value);
  }
  void insert(Epetra_CrsMatrix &matrix, int row) {
    matrix.InsertGlobalValues(row, int(columns.size()), values.data(), columns.data());
    columns.clear();
    values.clear();
  }
};

} // namespace

struct Simplec::Blocks {
  explicit Blocks(const fem::BlockMatrix<double> &A);
  void split(const fem::BlockMatrix<double> &A);
  void form_schur_complement();
  void solve_momentum(const Epetra_Vector &r, Epetra_Vector &u) const;
  void solve_schur(const Epetra_Vector &r, Epetra_Vector &p) const;

  Epetra_MpiComm communicator;
  Epetra_Map velocity, pressure;
  Epetra_CrsMatrix F, G, B, C, S; // S stays: the multigrid cycle works on it
  Epetra_Vector inverse_D;
  dealii::TrilinosWrappers::PreconditionAMG schur_amg;
};

Simplec::Blocks::Blocks(const fem::BlockMatrix<double> &A)
    : communicator(A.space().communicator()), velocity(-1, int(3 * A.space().n_owned_nodes()), 0, communicator),
      pressure(-1, int(A.space().n_owned_nodes()), 0, communicator), F(Copy, velocity, 0), G(Copy, velocity, 0),
      B(Copy, pressure, 0), C(Copy, pressure, 0), S(Copy, pressure, 0), inverse_D(velocity) {
  split(A);
  form_schur_complement();
}

void Simplec::Blocks::split(const fem::BlockMatrix<double> &A) {
  const fem::BlockPattern &pattern = *A.pattern();
  const int first = int(A.space().first_owned_node());
  Row to_velocity, to_pressure;
  for (int row = 0; row < 4 * pattern.n_rows(); ++row) {
    const int node = first + row / 4, i = row % 4;
    double sum = 0;
    for (int block = pattern.begin()[row / 4]; block < pattern.begin()[row / 4 + 1]; ++block) {
      const int column = int(A.space().global_node(pattern.columns()[block]));
      const double *values = A.values() + 16 * std::size_t(block) + i;
      for (int j = 0; j < 3; ++j) {
        to_velocity.add(3 * column + j, values[4 * j]);
        sum += std::abs(values[4 * j]);
      }
      to_pressure.add(column, values[12]);
    }
    to_velocity.insert(i < 3 ? F : B, i < 3 ? 3 * node + i : node);
    to_pressure.insert(i < 3 ? G : C, i < 3 ? 3 * node + i : node);
    if (i < 3)
      inverse_D[row / 4 * 3 + i] = 1 / sum;
  }
  F.FillComplete(velocity, velocity);
  G.FillComplete(pressure, velocity);
  B.FillComplete(velocity, pressure);
  C.FillComplete(pressure, pressure);
}

void Simplec::Blocks::form_schur_complement() {
  Epetra_CrsMatrix scaled_G(G);
  scaled_G.LeftScale(inverse_D);
  EpetraExt::MatrixMatrix::Multiply(B, false, scaled_G, false, S);
  EpetraExt::MatrixMatrix::Add(C, false, 1., S, -1.); // C - B D^-1 G, on the product's wider pattern
  dealii::TrilinosWrappers::PreconditionAMG::AdditionalData data;
  data.elliptic = true;
  data.aggregation_threshold = 1e-3;
  schur_amg.initialize(S, data);
}

/// Chebyshev's iteration on D^-1 F (Saad, Iterative Methods for Sparse Linear Systems, algorithm 12.1), whose
/// spectrum the row sums bound by one from above; what lies below the interval is damped less, but does not grow.
void Simplec::Blocks::solve_momentum(const Epetra_Vector &r, Epetra_Vector &u) const {
  const double low = 0.08, high = 1, centre = (high + low) / 2, radius = (high - low) / 2;
  const int steps = 4;
  Epetra_Vector direction(velocity), residual(r), product(velocity);
  double rho = radius / centre;
  direction.Multiply(1 / centre, inverse_D, residual, 0);
  u = direction;
  for (int k = 1; k < steps; ++k) {
    F.Multiply(false, direction, product);
    residual.Update(-1, product, 1);
    const double next = 1 / (2 * centre / radius - rho);
    direction.Multiply(2 * next / radius, inverse_D, residual, next * rho);
    u.Update(1, direction, 1);
    rho = next;
  }
}

void Simplec::Blocks::solve_schur(const Epetra_Vector &r, Epetra_Vector &p) const {
  schur_amg.trilinos_operator().ApplyInverse(r, p);
}

Simplec::Simplec(const fem::BlockMatrix<double> &matrix) : blocks_(std::make_unique<Blocks>(matrix)) {}

Simplec::~Simplec() = default;

void Simplec::vmult(fem::Vector &y, const fem::Vector &x) const {
  const Blocks &b = *blocks_;
  Epetra_Vector r_u(b.velocity), r_p(b.pressure), u(b.velocity), p(b.pressure), change(b.velocity),
      divergence(b.pressure);
  const int n_nodes = r_p.MyLength();
  for (int node = 0; node < n_nodes; ++node) {
    for (int i = 0; i < 3; ++i)
      r_u[3 * node + i] = x.local_element(4 * node + i);
    r_p[node] = x.local_element(4 * node + 3);
  }
  b.solve_momentum(r_u, u);
  b.B.Multiply(false, u, divergence);
  r_p.Update(-1, divergence, 1);
  b.solve_schur(r_p, p);
  b.G.Multiply(false, p, change);
  u.Multiply(-1, b.inverse_D, change, 1);
  for (int node = 0; node < n_nodes; ++node) {
    for (int i = 0; i < 3; ++i)
      y.local_element(4 * node + i) = u[3 * node + i];
    y.local_element(4 * node + 3) = p[node];
  }
}

} // namespace heartbus::fluid
