#include "common/linear_algebra/block_product_kernel.h"
#include "mech_solver/elasticity_problem.h"
#include "tests/benchmarks/heart.h"
#include "tests/benchmarks/limits.h"

namespace heartbus::benchmarks {

namespace {

using fem::VectorizedDouble;

// Additions and multiplications of a hexahedron with eight quadrature points, counted in elasticity_kernel.cpp.
constexpr double flops_residual = 8 * (8 * (3 * 5 + 9 * 2) + 28 + 30 + 150 + 16 + 54 + 3 * (17 + 8 * 8));
constexpr double flops_tangent = flops_residual + 8 * (200 + 810 + 8 * 9 * 3 * 5 + 36 * (9 * 6 + 6));

/// All of the wall, and what the kernel sees of it when all cells are read from its mesh.
struct Elasticity {
  Elasticity() : problem(wall.space, wall.fibres, scene().mech), d(smooth_displacement(wall.space)) {
    problem.past.fill(d);
    problem.begin_dynamic(dt);
    for (unsigned a = 0; a < 8; ++a)
      for (unsigned i = 0; i < 3; ++i)
        displacement[3 * a + i] = fem::lanes(1e-5 * ((a >> i) & 1));
  }
  mech::ElasticityCells cells(unsigned batch) const {
    const auto &space = wall.space;
    mech::ElasticityCells cells;
    cells.nodes_per_cell = space.nodes_per_cell();
    cells.n_q = space.n_q();
    cells.shapes = space.shapes();
    cells.gradients = space.gradients(batch);
    cells.JxW = space.JxW(batch);
    cells.frames = wall.fibres.frames(batch);
    cells.displacement = displacement.data();
    cells.inertia = inertia.data();
    cells.tension = inertia.data();
    cells.mass = 1e3 / (dt * dt);
    return cells;
  }
  double n_cells() const { return wall.space.n_global_cells(); }
  /// Gradients, frames and weights of the quadrature points.
  double bytes() const { return n_cells() * 8 * 8 * (24 + 9 + 1); }

  Wall wall;
  mech::ElasticityProblem problem;
  fem::Vector d;
  alignas(64) std::array<VectorizedDouble, 24> displacement{}, inertia{}, r{};
  alignas(64) std::array<VectorizedDouble, 24 * 24> K{};
};

Elasticity &elasticity() {
  static Elasticity all;
  return all;
}

void guccione_residual_kernel(benchmark::State &state) {
  Elasticity &e = elasticity();
  for (auto _ : state)
    for (unsigned batch = 0; batch < e.wall.space.n_batches(); ++batch) {
      mech::DeformationLimits limits;
      mech::add_residual(mech::Guccione(), e.cells(batch), e.r.data(), limits);
    }
  compare_with_limit(state, {e.n_cells(), e.bytes(), e.n_cells() * flops_residual});
}
BENCHMARK(guccione_residual_kernel)->Unit(benchmark::kMillisecond);

void guccione_tangent_kernel(benchmark::State &state) {
  Elasticity &e = elasticity();
  for (auto _ : state)
    for (unsigned batch = 0; batch < e.wall.space.n_batches(); ++batch) {
      mech::DeformationLimits limits;
      mech::add_residual_and_tangent(mech::Guccione(), e.cells(batch), e.r.data(), e.K.data(), limits);
    }
  compare_with_limit(state, {e.n_cells(), e.bytes(), e.n_cells() * flops_tangent});
}
BENCHMARK(guccione_tangent_kernel)->Unit(benchmark::kMillisecond);

/// Of 24 x 24 matrices: the values of the matrix pass once, with the positions of the blocks.
void guccione_insertion(benchmark::State &state) {
  Elasticity &e = elasticity();
  fem::BlockMatrix<double> matrix(e.wall.space, 3);
  for (auto _ : state)
    for (unsigned batch = 0; batch < e.wall.space.n_batches(); ++batch)
      matrix.add_batch(batch, e.K.data());
  compare_with_limit(state, {e.n_cells(), 16 * matrix.n_entries() + e.n_cells() * 8 * 8 * 4, e.n_cells() * 24 * 24});
}
BENCHMARK(guccione_insertion)->Unit(benchmark::kMillisecond);

/// Gathering, kernel, scattering, boundary terms.
void elasticity_residual(benchmark::State &state) {
  Elasticity &e = elasticity();
  fem::Vector r = e.d;
  for (auto _ : state)
    e.problem.residual(e.d, r);
  compare_with_limit(state, {e.n_cells(), e.bytes(), e.n_cells() * flops_residual});
}
BENCHMARK(elasticity_residual)->Unit(benchmark::kMillisecond);

/// Gathering, kernel, insertion, boundary terms.
void elasticity_tangent(benchmark::State &state) {
  Elasticity &e = elasticity();
  for (auto _ : state)
    e.problem.linearise(e.d);
  compare_with_limit(state,
                     {e.n_cells(), e.bytes() + 16 * e.problem.tangent().n_entries(), e.n_cells() * flops_tangent});
}
BENCHMARK(elasticity_tangent)->Unit(benchmark::kMillisecond);

void product(benchmark::State &state, const fem::BlockMatrix<double> &A) {
  fem::Vector x = A.space().make_vector(A.components()), y = x;
  x = 1;
  for (auto _ : state)
    A.vmult(y, x);
  const double n_blocks = A.n_entries() / (A.components() * A.components());
  compare_with_limit(state, {1, 8 * A.n_entries() + 4 * n_blocks + 24. * A.n_rows(), 2. * A.n_entries()});
}

void block_product_3(benchmark::State &state) { product(state, fem::BlockMatrix<double>(elasticity().wall.space, 3)); }
BENCHMARK(block_product_3)->Unit(benchmark::kMillisecond);

void block_product_4(benchmark::State &state) { product(state, fem::BlockMatrix<double>(elasticity().wall.space, 4)); }
BENCHMARK(block_product_4)->Unit(benchmark::kMillisecond);

/// Pattern and positions, at the start of a program.
void matrix_set_up(benchmark::State &state) {
  const auto &space = elasticity().wall.space;
  for (auto _ : state)
    fem::BlockMatrix<double>(space, 1);
  const fem::BlockMatrix<double> matrix(space, 1);
  compare_with_limit(state, {1, 16 * matrix.n_entries() + elasticity().n_cells() * 8 * (4 + 8 * 4), 0});
}
BENCHMARK(matrix_set_up)->Unit(benchmark::kMillisecond);

} // namespace

} // namespace heartbus::benchmarks
