#include "common/fem/lagrange_space.h"
#include "common/base/failure.h"
#include "common/fem/constraints.h"
#include "common/fem/on_root.h"
#include "common/geometry/mesh_tools.h"
#include "common/geometry/shapes.h"
#include "common/linear_algebra/block_ilu.h"
#include "common/linear_algebra/linear_solver.h"
#include "common/linear_algebra/trilinos_copy.h"
#include "mpi_test_main.h"

using namespace heartbus;
using fem::n_lanes;
using fem::VectorizedDouble;

namespace {

double global_sum(double x) { return dealii::Utilities::MPI::sum(x, MPI_COMM_WORLD); }

void assemble_laplace(const fem::LagrangeSpace &space, fem::BlockMatrix<double> &A) {
  const unsigned n = space.nodes_per_cell();
  std::vector<VectorizedDouble> K(n * n);
  A.clear();
  for (unsigned batch = 0; batch < space.n_batches(); ++batch) {
    std::fill(K.begin(), K.end(), VectorizedDouble{});
    for (unsigned q = 0; q < space.n_q(); ++q) {
      const VectorizedDouble *g = space.gradients(batch) + q * n * 3, w = space.JxW(batch)[q];
      for (unsigned a = 0; a < n; ++a)
        for (unsigned b = 0; b < n; ++b)
          K[a * n + b] += w * (g[3 * a] * g[3 * b] + g[3 * a + 1] * g[3 * b + 1] + g[3 * a + 2] * g[3 * b + 2]);
    }
    A.add_batch(batch, K.data());
  }
}

double exact(const geometry::Point3 &x) { return std::sin(2 * x[0]) * std::cos(3 * x[1]) * std::exp(x[2]); }

/// L2 error of -Lap u = (4 + 9 - 1) u with the exact solution on the whole boundary.
double poisson_error(const geometry::Mesh &mesh, unsigned refinements, unsigned degree) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, mesh, refinements, degree);
  const unsigned n = space.nodes_per_cell();
  fem::BlockMatrix<double> A(space, 1);
  std::vector<std::uint8_t> constrained(space.n_local_nodes());
  for (const auto &label : space.labels()) {
    const auto on = space.nodes_on(label);
    for (unsigned i = 0; i < on.size(); ++i)
      constrained[i] |= on[i];
  }
  fem::Vector u = space.make_vector(1), b = space.make_vector(1), correction = space.make_vector(1);
  for (unsigned i = 0; i < space.n_local_nodes(); ++i)
    u.begin()[i] = constrained[i] ? exact(space.points()[i]) : 0.0;
  for (unsigned slot = 0; slot < space.n_slots(); ++slot)
    for (unsigned q = 0; q < space.n_q() && space.slot_used(slot); ++q)
      for (unsigned a = 0; a < n; ++a)
        if (const unsigned node = space.cell_nodes(slot)[a]; node < space.n_owned_nodes()) {
          const double w = space.JxW(slot / n_lanes)[q][slot % n_lanes];
          b.local_element(node) += w * space.shapes()[q * n + a] * 12 * exact(space.quadrature_point(slot, q));
        }
  // Without constraints for the residual of the boundary values, with them for the correction.
  assemble_laplace(space, A);
  fem::Vector Au = space.make_vector(1);
  A.vmult(Au, u);
  b -= Au;
  fem::zero_constrained(b, constrained);
  A.set_constraints(constrained);
  assemble_laplace(space, A);
  solve_linear("Poisson", A, correction, b, *fem::make_preconditioner("amg", A), 1e-10);
  u += correction;
  u.update_ghost_values();
  double error = 0;
  for (unsigned slot = 0; slot < space.n_slots(); ++slot)
    for (unsigned q = 0; q < space.n_q() && space.slot_owned(slot); ++q) {
      double value = -exact(space.quadrature_point(slot, q));
      for (unsigned a = 0; a < n; ++a)
        value += space.shapes()[q * n + a] * u.begin()[space.cell_nodes(slot)[a]];
      error += space.JxW(slot / n_lanes)[q][slot % n_lanes] * value * value;
    }
  return std::sqrt(global_sum(error));
}

} // namespace

TEST(LagrangeSpace, MeasuresVolumeAndSurfaceOfABox) {
  const geometry::Mesh box = geometry::make_box({0, 0, 0}, {1, 2, 3}, {3, 2, 4});
  for (const auto &[mesh, degree] : {std::pair(box, 1u), std::pair(geometry::make_tetrahedra(box), 1u),
                                     std::pair(geometry::make_tetrahedra(box), 2u)}) {
    const fem::LagrangeSpace space(MPI_COMM_WORLD, mesh, 1, degree);
    double volume = 0, area = 0;
    for (unsigned batch = 0; batch < space.n_owned_batches(); ++batch)
      for (unsigned q = 0; q < space.n_q(); ++q)
        for (unsigned lane = 0; lane < n_lanes; ++lane)
          volume += space.JxW(batch)[q][lane];
    const auto top = space.faces("z_high");
    for (unsigned f = 0; f < top.n_faces; ++f)
      for (unsigned q = 0; q < top.n_q; ++q) {
        EXPECT_NEAR(top.normals[(f * top.n_q + q) * 3 + 2], 1, 1e-14);
        area += top.owned[f] ? top.JxW[f * top.n_q + q] : 0;
      }
    EXPECT_EQ(space.n_global_cells(), mesh.n_cells() * 8);
    EXPECT_NEAR(global_sum(volume), 6, 1e-12); // the sum of 40,000 parts
    EXPECT_NEAR(global_sum(area), 2, 1e-12);
  }
}

/// The halves of all edges, and nothing twice: a box of n cells a side has (n + 1)^3 vertices, and as many diagonals as
/// faces once each.
TEST(LagrangeSpace, RefinedTetrahedraShareTheirNodes) {
  const geometry::Mesh mesh = geometry::make_tetrahedra(geometry::make_box({0, 0, 0}, {1, 1, 1}, {2, 2, 2}));
  const fem::LagrangeSpace refined(MPI_COMM_WORLD, mesh, 1, 1), quadratic(MPI_COMM_WORLD, mesh, 0, 2);
  const unsigned edges = 3 * 2 * 3 * 3 + 3 * 3 * 2 * 2; // of the hexahedra, and a diagonal of each of their faces
  EXPECT_EQ(refined.n_global_nodes(), 27u + edges);
  EXPECT_EQ(quadratic.n_global_nodes(), 27u + edges);
}

TEST(LagrangeSpace, QuadratureDoesNotDependOnHowVerticesOfTetrahedraAreNumbered) {
  const auto mesh = geometry::make_tetrahedra(geometry::make_box({0, 0, 0}, {1, 2, 3}, {2, 2, 2}));
  geometry::Mesh renumbered = mesh;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) { // three of the four, turned in a circle
    unsigned *vertices = &renumbered.cells[4 * cell] + cell % 2;
    std::rotate(vertices, vertices + 1, vertices + 3);
  }
  for (const unsigned degree : {1u, 2u}) {
    double integrals[2] = {};
    for (const bool again : {false, true}) {
      const fem::LagrangeSpace space(MPI_COMM_WORLD, again ? renumbered : mesh, 0, degree);
      for (unsigned slot = 0; slot < space.n_slots(); ++slot)
        for (unsigned q = 0; q < space.n_q() && space.slot_owned(slot); ++q)
          integrals[again] += space.JxW(slot / n_lanes)[q][slot % n_lanes] * exact(space.quadrature_point(slot, q));
    }
    EXPECT_NEAR(global_sum(integrals[0]), global_sum(integrals[1]), 1e-12) << degree;
  }
}

TEST(LagrangeSpace, NodesOnALabelAreThoseThatLieOnIt) {
  const geometry::Mesh box = geometry::make_box({0, 0, 0}, {1, 1, 1}, {3, 3, 3});
  for (const auto &[mesh, degree] : {std::pair(box, 1u), std::pair(geometry::make_tetrahedra(box), 1u),
                                     std::pair(geometry::make_tetrahedra(box), 2u)}) {
    const fem::LagrangeSpace space(MPI_COMM_WORLD, mesh, 0, degree);
    const auto on = space.nodes_on("y_high");
    for (unsigned node = 0; node < space.n_local_nodes(); ++node)
      EXPECT_EQ(bool(on[node]), space.points()[node][1] > 1 - 1e-12);
  }
}

TEST(LagrangeSpace, WhatAMeshSaysOfItsCellsReachesThemFromTheFirstRank) {
  const auto region = [](const geometry::Point3 &x) {
    return unsigned(x[0]) + 4 * unsigned(x[1]) + 12 * unsigned(x[2]);
  };
  const auto make = [&] {
    geometry::Mesh mesh = geometry::make_box({0, 0, 0}, {4, 3, 2}, {4, 3, 2});
    mesh.material_names.assign(24, "");
    for (unsigned cell = 0; cell < mesh.n_cells(); ++cell) {
      mesh.materials[cell] = region(mesh.points[mesh.cells[8 * cell]]);
      mesh.fibres.push_back({geometry::Point3{std::cos(cell), std::sin(cell), 0}, geometry::Point3{0, 0, 1}});
    }
    return mesh;
  };
  const geometry::Mesh mesh = fem::mesh_on_root(MPI_COMM_WORLD, make);
  EXPECT_EQ(mesh.points.empty(), dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) != 0);
  const fem::LagrangeSpace space(MPI_COMM_WORLD, mesh, 1);
  EXPECT_EQ(space.material_names().size(), 24u);
  for (unsigned slot = 0; slot < space.n_slots(); ++slot) {
    const unsigned here = region(space.quadrature_point(slot, 0));
    EXPECT_EQ(space.material(slot), here);
    EXPECT_EQ(space.fibre(slot)->at(0)[1], std::sin(here)); // cells of a box are numbered as the regions are
  }
}

TEST(LagrangeSpace, WhatTheFirstRankRefusesEndsAll) {
  const auto refuse = []() -> geometry::Mesh { throw Failure(ExitCode::file, "damaged"); };
  try {
    fem::mesh_on_root(MPI_COMM_WORLD, refuse);
    FAIL();
  } catch (const Failure &failure) {
    EXPECT_EQ(failure.code(), ExitCode::file);
    EXPECT_STREQ(failure.what(), "damaged");
  }
}

TEST(BlockMatrix, RowsAreCompleteWithoutCommunication) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, geometry::make_box({0, 0, 0}, {1, 1, 1}, {4, 4, 4}));
  fem::BlockMatrix<double> A(space, 1);
  assemble_laplace(space, A);
  fem::Vector x = space.make_vector(1), y = space.make_vector(1);
  for (unsigned i = 0; i < space.n_owned_nodes(); ++i)
    x.local_element(i) = space.points()[i][0];
  A.vmult(y, x); // grad x . grad x integrated: the area, once at each end
  EXPECT_NEAR(x * y, 1, 1e-13);
  x = 1;
  A.vmult(y, x);
  EXPECT_LT(y.linfty_norm(), 1e-13);
}

TEST(BlockMatrix, MultipliesAsTrilinosDoes) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, geometry::make_box({0, 0, 0}, {1, 1, 1}, {5, 4, 3}));
  for (const unsigned c : {1u, 3u, 4u}) {
    fem::BlockMatrix<double> A(space, c);
    for (std::size_t k = 0; k < A.n_entries(); ++k)
      A.values()[k] = std::sin(1. + 3. * k);
    fem::Vector x = space.make_vector(c), y = x, z = x;
    for (unsigned k = 0; k < x.locally_owned_size(); ++k)
      x.local_element(k) = std::cos(1. + k);
    auto copy = fem::trilinos_copy(A);
    for (std::size_t k = 0; k < A.n_entries(); ++k)
      A.values()[k] *= 1 + k % 5;
    fem::copy_values(A, *copy);
    A.vmult(y, x);
    EXPECT_FALSE(x.has_ghost_elements());
    Epetra_Vector x_copy(copy->DomainMap()), y_copy(copy->RangeMap());
    std::copy_n(x.begin(), A.n_rows(), &x_copy[0]);
    copy->Multiply(false, x_copy, y_copy);
    std::copy_n(&y_copy[0], A.n_rows(), z.begin());
    z -= y;
    EXPECT_LT(z.linfty_norm(), 1e-12 * y.linfty_norm());
    fem::BlockMatrix<float>(A).vmult(z, x);
    z -= y;
    EXPECT_LT(z.linfty_norm(), 1e-6 * y.linfty_norm());
  }
}

TEST(DirectSolver, InvertsWhatCanBeInverted) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, geometry::make_box({0, 0, 0}, {1, 1, 1}, {5, 4, 3}));
  for (const unsigned c : {1u, 3u}) {
    fem::BlockMatrix<double> A(space, c);
    EXPECT_THROW(fem::make_preconditioner("direct", A), Failure) << "of zeros";
    for (std::size_t k = 0; k < A.n_entries(); ++k)
      A.values()[k] = std::sin(1. + 3. * k * k);
    fem::Vector x = space.make_vector(c), b = x, y = x;
    for (unsigned k = 0; k < x.locally_owned_size(); ++k)
      x.local_element(k) = std::cos(1. + k);
    A.vmult(b, x);
    fem::make_preconditioner("direct", A)->vmult(y, b);
    y -= x;
    EXPECT_LT(y.linfty_norm(), 1e-10);
  }
}

TEST(LagrangeSpace, PoissonConvergesWithOrderTwoOnHexahedra) {
  const auto box = geometry::make_box({0, 0, 0}, {1, 1, 1}, {4, 4, 4});
  const double coarse = poisson_error(box, 0, 1), fine = poisson_error(box, 1, 1);
  EXPECT_NEAR(std::log2(coarse / fine), 2, 0.15);
}

TEST(LagrangeSpace, PoissonConvergesWithOrderTwoAndThreeOnTetrahedra) {
  const auto mesh = [](unsigned n) {
    return geometry::make_tetrahedra(geometry::make_box({0, 0, 0}, {1, 1, 1}, {n, n, n}));
  };
  EXPECT_NEAR(std::log2(poisson_error(mesh(4), 0, 1) / poisson_error(mesh(8), 0, 1)), 2, 0.2);
  EXPECT_GT(std::log2(poisson_error(mesh(4), 0, 1) / poisson_error(mesh(4), 1, 1)), 1.7); // refined: other shapes
  EXPECT_NEAR(std::log2(poisson_error(mesh(3), 0, 2) / poisson_error(mesh(6), 0, 2)), 3, 0.3);
}

TEST(BlockMatrix, ThreefoldProductIsThatOfEachComponent) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, geometry::make_box({0, 0, 0}, {1, 1, 1}, {5, 4, 3}));
  fem::BlockMatrix<double> A(space, 1);
  assemble_laplace(space, A);
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
    A.add_diagonal(node, 1);
  const fem::BlockILU ilu(A);
  fem::Vector x = space.make_vector(3), y(x), z(x), x_i = space.make_vector(1), y_i(x_i), z_i(x_i);
  for (unsigned k = 0; k < x.locally_owned_size(); ++k)
    x.local_element(k) = std::cos(7. * k);
  A.vmult_3rhs(y, x);
  ilu.vmult_3rhs(z, x);
  for (unsigned i = 0; i < 3; ++i) {
    for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
      x_i.local_element(node) = x.local_element(3 * node + i);
    A.vmult(y_i, x_i);
    ilu.vmult(z_i, x_i);
    for (unsigned node = 0; node < space.n_owned_nodes(); ++node) {
      EXPECT_NEAR(y.local_element(3 * node + i), y_i.local_element(node), 1e-13);
      EXPECT_NEAR(z.local_element(3 * node + i), z_i.local_element(node), 1e-13);
    }
  }
}

TEST(BlockMatrix, ConstraintsLeaveTheDiagonalOnly) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, geometry::make_box({0, 0, 0}, {1, 1, 1}, {5, 4, 3}));
  fem::BlockMatrix<double> A(space, 3);
  fem::Constraints constrained(3 * space.n_local_nodes());
  fem::fix_vector(space, 3, space.labels().front(), constrained);
  A.set_constraints(constrained);
  std::vector<VectorizedDouble> K(9 * space.nodes_per_cell() * space.nodes_per_cell());
  for (unsigned batch = 0; batch < space.n_batches(); ++batch) {
    std::fill(K.begin(), K.end(), fem::lanes(1));
    A.add_batch(batch, K.data());
  }
  fem::Vector fixed = space.make_vector(3), free(fixed), y(fixed);
  for (unsigned k = 0; k < fixed.locally_owned_size(); ++k)
    (constrained[k] ? fixed : free).local_element(k) = 1;
  A.vmult(y, fixed);
  for (unsigned k = 0; k < y.locally_owned_size(); ++k)
    EXPECT_EQ(y.local_element(k) > 0, bool(constrained[k])); // as many as there are cells around
  A.vmult(y, free);
  for (unsigned k = 0; k < y.locally_owned_size(); ++k)
    EXPECT_EQ(y.local_element(k) > 0, !constrained[k]);
}

namespace {

/// Assembles the same cells in both, with constraints on one side.
void compare_precisions(const fem::LagrangeSpace &space, unsigned c) {
  fem::BlockMatrix<double> A(space, c);
  fem::BlockMatrix<float> rounded(A.pattern(), c);
  fem::Constraints constrained(c * space.n_local_nodes());
  if (c >= 3)
    fem::fix_vector(space, c, space.labels().front(), constrained);
  A.set_constraints(constrained);
  rounded.set_constraints(constrained);
  const unsigned n = space.nodes_per_cell();
  std::vector<VectorizedDouble> K(c * c * n * n);
  for (unsigned batch = 0; batch < space.n_batches(); ++batch) {
    for (std::size_t k = 0; k < K.size(); ++k)
      for (unsigned lane = 0; lane < n_lanes; ++lane)
        K[k][lane] = std::sin(1. + 3. * double(k) + 7. * lane + 11. * batch);
    std::vector<VectorizedDouble> same(K); // what is added is reduced by the constraints
    A.add_batch(batch, same.data());
    rounded.add_batch(batch, K.data());
  }
  fem::Vector x = space.make_vector(c), y(x), z(x);
  for (unsigned k = 0; k < x.locally_owned_size(); ++k)
    x.local_element(k) = std::cos(7. * k);
  A.vmult(y, x);
  rounded.vmult(z, x);
  z -= y;
  EXPECT_LT(z.linfty_norm(), 1e-6 * y.linfty_norm());
  const fem::BlockMatrix<double> copy(rounded);
  for (std::size_t k = 0; k < A.n_entries(); ++k)
    EXPECT_NEAR(copy.values()[k], A.values()[k], 1e-5);
}

} // namespace

TEST(BlockMatrix, AssembledInSinglePrecisionItIsTheSameMatrix) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, geometry::make_box({0, 0, 0}, {1, 1, 1}, {5, 4, 3}));
  for (const unsigned c : {1u, 3u, 4u})
    compare_precisions(space, c);
}

namespace {

unsigned iterations_with_ilu(MPI_Comm communicator) {
  const fem::LagrangeSpace space(communicator, geometry::make_box({0, 0, 0}, {1, 1, 1}, {16, 16, 16}));
  fem::BlockMatrix<double> A(space, 1);
  assemble_laplace(space, A);
  fem::Vector x = space.make_vector(1), b(x);
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node) {
    A.add_diagonal(node, space.cell_size(0)); // as mass dominates a time step
    b.local_element(node) = std::sin(30 * space.points()[node][0] + 20 * space.points()[node][1]);
  }
  return solve_linear("a box", A, x, b, fem::BlockILU(A), 1e-8).iterations;
}

} // namespace

TEST(BlockILU, OverlapMakesUpForTheBorderBetweenRanks) {
  const unsigned alone = iterations_with_ilu(MPI_COMM_SELF), together = iterations_with_ilu(MPI_COMM_WORLD);
  EXPECT_GT(alone, 5u);
  EXPECT_LE(together, alone + 2);
}

namespace {

/// Far from symmetric.
struct Skewed : fem::Preconditioner {
  void vmult(fem::Vector &y, const fem::Vector &x) const override {
    for (unsigned i = 0; i < x.locally_owned_size(); ++i)
      y.local_element(i) = x.local_element(i) + 0.9 * x.local_element(i > 0 ? i - 1 : 0);
  }
};

struct Identity : fem::Preconditioner {
  void vmult(fem::Vector &y, const fem::Vector &x) const override { y = x; }
};

} // namespace

TEST(SolveLinear, ReachesItsToleranceThroughRestartsAndWithAnyPreconditioner) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, geometry::make_box({0, 0, 0}, {1, 1, 1}, {12, 12, 12}));
  fem::BlockMatrix<double> A(space, 1);
  assemble_laplace(space, A);
  fem::Vector x = space.make_vector(1), b(x), r(x);
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node) {
    A.add_diagonal(node, 1e-3 * space.cell_size(0));
    b.local_element(node) = std::sin(30 * space.points()[node][0]);
    x.local_element(node) = 1;
  }
  const auto statistics = solve_linear("a box", A, x, b, Skewed(), 1e-8, 2000);
  EXPECT_GT(statistics.iterations, 80u); // a restart
  A.vmult(r, x);
  r -= b;
  EXPECT_LE(r.l2_norm(), 1.001e-8 * b.l2_norm());
  EXPECT_NEAR(statistics.residual, r.l2_norm(), 1e-3 * r.l2_norm());
}

/// As many iterations as the matrix has different eigenvalues; the residual falls by 1e12 in them.
TEST(SolveLinear, KeepsItsBasisOrthogonal) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, geometry::make_box({0, 0, 0}, {1, 1, 1}, {8, 8, 8}));
  constexpr unsigned n_eigenvalues = 20;
  fem::BlockMatrix<double> A(space, 1);
  fem::Vector x = space.make_vector(1), b(x), r(x);
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node) {
    b.local_element(node) = 1 + node % 3;
    A.add_diagonal(node, 1. + node % n_eigenvalues);
  }
  const auto statistics = solve_linear("a diagonal", A, x, b, Identity(), 1e-12, 30);
  EXPECT_EQ(statistics.iterations, n_eigenvalues);
  A.vmult(r, x);
  r -= b;
  EXPECT_LE(r.l2_norm(), 2e-12 * b.l2_norm());
}

TEST(SolveLinear, SaysHowFarItCame) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, geometry::make_box({0, 0, 0}, {1, 1, 1}, {6, 6, 6}));
  fem::BlockMatrix<double> A(space, 1);
  assemble_laplace(space, A);
  fem::Vector x = space.make_vector(1), b(x);
  b.local_element(0) = 1;
  try {
    solve_linear("a box", A, x, b, Identity(), 1e-12, 3);
    FAIL() << "three iterations cannot be enough";
  } catch (const Failure &failure) {
    EXPECT_EQ(failure.code(), ExitCode::not_converged);
    EXPECT_NE(std::string(failure.what()).find("a box: GMRES stopped after 3 iterations"), std::string::npos);
  }
}

TEST(Partition, RanksVisitEquallyManyCells) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, geometry::make_box({0, 0, 0}, {1, 1, 1}, {8, 8, 16}));
  unsigned visited = 0;
  for (unsigned slot = 0; slot < space.n_slots(); ++slot)
    visited += space.slot_used(slot);
  const unsigned most = dealii::Utilities::MPI::max(visited, MPI_COMM_WORLD);
  const double mean = global_sum(visited) / dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD);
  EXPECT_LE(most, 1.03 * mean); // equal numbers of own cells: 1.06
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
