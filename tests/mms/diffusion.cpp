#include "common/geometry/mesh_tools.h"
#include "ep_solver/monodomain_problem.h"
#include "mpi_test_main.h"
#include "tests/mms/conductivities.h"

#include <cmath>

using namespace heartbus;

namespace {

/// v = (1 + t) g(x), g = product of sin^2(pi x_i): its gradient vanishes on the boundary of the unit cube, so D grad v
/// . n does, whatever D is; and implicit Euler is exact in time.
struct Manufactured {
  Tensor D{{{2, 0.7, 0.3}, {0.7, 1, -0.2}, {0.3, -0.2, 0.5}}};
  static double s(double x) { return std::pow(std::sin(M_PI * x), 2); }
  static double ds(double x) { return M_PI * std::sin(2 * M_PI * x); }
  static double dds(double x) { return 2 * M_PI * M_PI * std::cos(2 * M_PI * x); }
  static double g(const geometry::Point3 &x) { return s(x[0]) * s(x[1]) * s(x[2]); }
  double div_D_grad_g(const geometry::Point3 &x) const {
    double sum = 0;
    for (unsigned i = 0; i < 3; ++i)
      for (unsigned j = 0; j < 3; ++j) {
        double term = D[i][j];
        for (unsigned k = 0; k < 3; ++k)
          term *= k == i && k == j ? dds(x[k]) : k == i || k == j ? ds(x[k]) : s(x[k]);
        sum += term;
      }
    return sum;
  }
};

double manufactured_error(unsigned n_cells, bool tetrahedra = false, unsigned degree = 1) {
  geometry::Mesh mesh = geometry::make_box({0, 0, 0}, {1, 1, 1}, {n_cells, n_cells, n_cells});
  for (auto &x : mesh.points) { // no two cells alike, the cube kept
    const double bump = 0.06 * std::sin(M_PI * x[0]) * std::sin(M_PI * x[1]) * std::sin(M_PI * x[2]);
    x = {x[0] + bump, x[1] - bump, x[2] + 0.5 * bump};
  }
  const fem::LagrangeSpace space(MPI_COMM_WORLD, tetrahedra ? geometry::make_tetrahedra(mesh) : mesh, 0, degree);
  const Manufactured exact;
  ep::MonodomainProblem problem(space, constant(exact.D)(space), 1e-12, "jacobi");
  const double dt = 0.1;
  problem.set_step(dt);
  fem::Vector v_n = space.make_vector(1), v = v_n, I = v_n;
  for (unsigned i = 0; i < space.n_owned_nodes(); ++i)
    v_n.local_element(i) = Manufactured::g(space.points()[i]);
  double t = 0;
  for (int n = 0; n < 5; ++n, v_n = v) {
    t += dt;
    for (unsigned i = 0; i < space.n_owned_nodes(); ++i)
      I.local_element(i) = Manufactured::g(space.points()[i]) - (1 + t) * exact.div_D_grad_g(space.points()[i]);
    problem.solve(v_n, I, v);
  }
  v.update_ghost_values();
  double error = 0;
  for (unsigned slot = 0; slot < space.n_slots(); ++slot)
    for (unsigned q = 0; space.slot_owned(slot) && q < space.n_q(); ++q) {
      double v_q = 0;
      for (unsigned a = 0; a < space.nodes_per_cell(); ++a)
        v_q += space.shapes()[q * space.nodes_per_cell() + a] * v.begin()[space.cell_nodes(slot)[a]];
      const double w = space.JxW(slot / fem::n_lanes)[q][slot % fem::n_lanes];
      error += w * std::pow(v_q - (1 + t) * Manufactured::g(space.quadrature_point(slot, q)), 2);
    }
  return std::sqrt(dealii::Utilities::MPI::sum(error, MPI_COMM_WORLD));
}

} // namespace

TEST(Diffusion, AnisotropicDiffusionIsOfOrderTwoOnDistortedCells) {
  const double coarse = manufactured_error(10), fine = manufactured_error(20);
  EXPECT_GT(std::log2(coarse / fine), 1.9);
  EXPECT_LT(fine, 0.01);
}

TEST(Diffusion, AnisotropicDiffusionIsOfOrderTwoAndThreeOnTetrahedra) {
  const double linear = manufactured_error(16, true), quadratic = manufactured_error(8, true, 2);
  EXPECT_GT(std::log2(manufactured_error(8, true) / linear), 1.8);
  EXPECT_GT(std::log2(manufactured_error(4, true, 2) / quadratic), 2.7);
  EXPECT_LT(quadratic, linear / 2); // as many nodes
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
