#include "common/linear_algebra/block_ilu.h"
#include "fluid_solver/navier_stokes_problem.h"
#include "tests/benchmarks/heart.h"
#include "tests/benchmarks/limits.h"

namespace heartbus::benchmarks {

namespace {

using fem::VectorizedDouble;

// Additions and multiplications of a hexahedron with eight quadrature points, counted in navier_stokes_kernel.cpp:
// pairs of nodes, residual, what is evaluated at the points.
constexpr double flops =
    8 * (8 * 8 * (2 + 18 + 18 + 6 + 12 + 12 + 2)) + 8 * 8 * 32 + 8 * 8 * 15 + 8 * (8 * (18 + 15 + 18 + 6 + 8) + 250);

struct Blood {
  Blood()
      : space(MPI_COMM_WORLD, geometry::make_fluid(scene().geometry)), problem(space, scene().fluid, 5000, dt),
        motion(smooth_displacement(space)) {
    motion *= 1e-2;
    problem.add_orifice("mitral", 1333, 0).open = true;
    problem.add_orifice("aortic", 9000, 1.3e7);
    problem.start(space.make_vector(3));
    problem.prepare(motion);
    const fem::Vector wall = space.make_vector(4);
    problem.solve(wall, wall);
    problem.commit();
    problem.prepare(motion);
  }
  double n_cells() const { return space.n_global_cells(); }
  double bytes() const { return n_cells() * 8 * 8 * (24 + 1); } ///< gradients and weights of the quadrature points

  fem::LagrangeSpace space;
  fluid::NavierStokesProblem problem;
  fem::Vector motion;
};

Blood &blood() {
  static Blood all;
  return all;
}

void navier_stokes_kernel(benchmark::State &state) {
  const Blood &b = blood();
  alignas(64) std::array<VectorizedDouble, 24> zero{};
  alignas(64) std::array<VectorizedDouble, 32> x{}, r;
  alignas(64) std::array<VectorizedDouble, 32 * 32> K;
  const double unit_nodes[24] = {-1, -1, -1, 1, -1, -1, -1, 1, -1, 1, 1, -1, -1, -1, 1, 1, -1, 1, -1, 1, 1, 1, 1, 1};
  fluid::NavierStokesCells cells;
  cells.nodes_per_cell = cells.n_q = 8;
  cells.shapes = b.space.shapes();
  cells.unit_nodes = unit_nodes;
  cells.rho = scene().fluid.density;
  cells.mu = scene().fluid.viscosity;
  cells.dt = dt;
  cells.ale_displacement = cells.convection = cells.old_velocity = zero.data();
  cells.state = x.data();
  for (auto _ : state)
    for (unsigned batch = 0; batch < b.space.n_batches(); ++batch) {
      cells.gradients = b.space.gradients(batch);
      cells.JxW = b.space.JxW(batch);
      VectorizedDouble smallest_J;
      fluid::integrate_navier_stokes(cells, K.data(), r.data(), smallest_J);
    }
  compare_with_limit(state, {b.n_cells(), b.bytes(), b.n_cells() * flops});
}
BENCHMARK(navier_stokes_kernel)->Unit(benchmark::kMillisecond);

/// Of 32 x 32 matrices: the values of the matrix pass once, with the positions of the blocks.
void navier_stokes_insertion(benchmark::State &state) {
  const Blood &b = blood();
  fem::BlockMatrix<float> matrix(b.space, 4);
  alignas(64) static std::array<VectorizedDouble, 32 * 32> K{};
  for (auto _ : state)
    for (unsigned batch = 0; batch < b.space.n_batches(); ++batch)
      matrix.add_batch(batch, K.data());
  compare_with_limit(state, {b.n_cells(), 8 * matrix.n_entries() + b.n_cells() * 8 * 8 * 4, b.n_cells() * 32 * 32});
}
BENCHMARK(navier_stokes_insertion)->Unit(benchmark::kMillisecond);

/// All of a step but the solution: gathering, kernel, insertion, surfaces, a product.
void navier_stokes_prepare(benchmark::State &state) {
  Blood &b = blood();
  for (auto _ : state)
    b.problem.prepare(b.motion);
  compare_with_limit(state, {b.n_cells(), b.bytes() + 12 * b.problem.matrix().n_entries(), b.n_cells() * flops});
}
BENCHMARK(navier_stokes_prepare)->Unit(benchmark::kMillisecond);

void block_ILU_set_up(benchmark::State &state) {
  const fem::BlockMatrix<float> &A = blood().problem.matrix();
  for (auto _ : state)
    fem::BlockILU ilu(A);
  compare_with_limit(state, {1, (8. + 4) * A.n_entries(), 0});
}
BENCHMARK(block_ILU_set_up)->Unit(benchmark::kMillisecond);

/// Forwards and backwards: factors in single precision and columns once, vectors up and down.
void block_ILU_sweep(benchmark::State &state) {
  const fem::BlockMatrix<float> &A = blood().problem.matrix();
  const fem::BlockILU ilu(A);
  fem::Vector x = A.space().make_vector(4), y = x;
  x = 1;
  for (auto _ : state)
    ilu.vmult(y, x);
  compare_with_limit(state, {1, (4 + 4. / 16) * A.n_entries() + 5. * 8 * A.n_rows(), 2. * A.n_entries()});
}
BENCHMARK(block_ILU_sweep)->Unit(benchmark::kMillisecond);

} // namespace

} // namespace heartbus::benchmarks
