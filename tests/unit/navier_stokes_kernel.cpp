#include "fluid_solver/models/navier_stokes_kernel.h"
#include "common/simd/small_matrix.h"
#include "fluid_solver/models/stabilization.h"

#include <gtest/gtest.h>

#include <chrono>
#include <vector>

using namespace heartbus;
using fem::VectorizedDouble;

namespace {

/// Equal bricks of edges h[3], with 2x2x2 Gauss points.
struct Bricks : testing::Test {
  static constexpr unsigned n = 8, n_q = 8;
  const double h[3] = {2e-3, 3e-3, 4e-3};
  std::vector<double> shapes = std::vector<double>(n_q * n), unit_nodes = std::vector<double>(n * 3);
  std::vector<VectorizedDouble> gradients = std::vector<VectorizedDouble>(n_q * n * 3),
                                JxW = std::vector<VectorizedDouble>(n_q);
  std::vector<VectorizedDouble> motion = std::vector<VectorizedDouble>(n * 3), convection = motion,
                                old_velocity = motion;
  std::vector<VectorizedDouble> state = std::vector<VectorizedDouble>(n * 4), r = state;
  std::vector<VectorizedDouble> K = std::vector<VectorizedDouble>(n * n * 16);
  VectorizedDouble smallest_J{};
  fluid::NavierStokesCells cells;

  Bricks() {
    const double g = 1 / std::sqrt(3.);
    for (unsigned q = 0; q < n_q; ++q) {
      JxW[q] = fem::lanes(h[0] * h[1] * h[2] / 8);
      for (unsigned a = 0; a < n; ++a) {
        double N[3], dN[3];
        for (unsigned i = 0; i < 3; ++i) {
          const double side = (a >> i) & 1 ? 1 : -1, xi = (q >> i) & 1 ? g : -g;
          unit_nodes[3 * a + i] = side;
          N[i] = (1 + side * xi) / 2;
          dN[i] = side / h[i];
        }
        shapes[q * n + a] = N[0] * N[1] * N[2];
        gradients[(q * n + a) * 3 + 0] = fem::lanes(dN[0] * N[1] * N[2]);
        gradients[(q * n + a) * 3 + 1] = fem::lanes(N[0] * dN[1] * N[2]);
        gradients[(q * n + a) * 3 + 2] = fem::lanes(N[0] * N[1] * dN[2]);
      }
    }
    for (unsigned a = 0; a < n; ++a)
      for (unsigned i = 0; i < 3; ++i)
        for (unsigned lane = 0; lane < fem::n_lanes; ++lane)
          motion[3 * a + i][lane] = 1e-4 * std::sin(1. + 5 * a + 3 * i + lane);
    cells.nodes_per_cell = n;
    cells.n_q = n_q;
    cells.shapes = shapes.data();
    cells.gradients = gradients.data();
    cells.JxW = JxW.data();
    cells.unit_nodes = unit_nodes.data();
    cells.rho = 1060;
    cells.mu = 3.5e-3;
    cells.dt = 2e-4;
    cells.pressure_scale = 1e4;
    cells.ale_displacement = motion.data();
    cells.convection = convection.data();
    cells.old_velocity = old_velocity.data();
    cells.state = state.data();
  }
  void integrate() { fluid::integrate_navier_stokes(cells, K.data(), r.data(), smallest_J); }
};

TEST_F(Bricks, UniformFlowLeavesNoResidualOnAMovingCell) {
  for (unsigned a = 0; a < n; ++a)
    for (unsigned i = 0; i < 3; ++i) {
      state[4 * a + i] = old_velocity[3 * a + i] = fem::lanes(0.3 + 0.2 * i);
      for (unsigned lane = 0; lane < fem::n_lanes; ++lane)
        convection[3 * a + i][lane] = std::cos(a + 7. * i + lane);
    }
  integrate();
  const double scale = cells.rho / cells.dt * h[0] * h[1] * h[2];
  for (const VectorizedDouble &entry : r)
    for (unsigned lane = 0; lane < fem::n_lanes; ++lane)
      EXPECT_LT(std::abs(entry[lane]), 1e-14 * scale);
}

TEST_F(Bricks, ResidualIsTheMatrixTimesTheStateMinusTheLoad) {
  for (unsigned a = 0; a < n; ++a)
    for (unsigned i = 0; i < 3; ++i)
      convection[3 * a + i] = old_velocity[3 * a + i] = fem::lanes(std::sin(1. + a - 2. * i));
  integrate();
  const std::vector<VectorizedDouble> r0 = r;
  for (unsigned k = 0; k < 4 * n; ++k)
    state[k] = fem::lanes(std::cos(3. * k));
  integrate();
  for (unsigned a = 0; a < n; ++a)
    for (unsigned i = 0; i < 4; ++i) {
      double product = 0, size = 0;
      for (unsigned b = 0; b < n; ++b)
        for (unsigned j = 0; j < 4; ++j) {
          product += K[((a * n + b) * 4 + i) * 4 + j][3] * state[4 * b + j][3];
          size += std::abs(K[((a * n + b) * 4 + i) * 4 + j][3]);
        }
      EXPECT_NEAR(r[4 * a + i][3] - r0[4 * a + i][3], product, 1e-13 * size);
    }
}

TEST_F(Bricks, AConstantPressurePushesTheMovedFacesOutwards) {
  for (unsigned a = 0; a < n; ++a) // the brick stretched by 1.5 along x
    for (unsigned i = 0; i < 3; ++i)
      motion[3 * a + i] = fem::lanes(i == 0 && (a & 1) ? 0.5 * h[0] : 0);
  for (unsigned a = 0; a < n; ++a)
    state[4 * a + 3] = fem::lanes(0.2);
  integrate();
  const double pressure = 0.2 * cells.pressure_scale;
  EXPECT_NEAR(smallest_J[0], 1.5, 1e-12);
  EXPECT_NEAR(r[4 * 1 + 0][0], -pressure * h[1] * h[2] / 4, 1e-10);
  EXPECT_NEAR(r[4 * 1 + 1][0], +pressure * 1.5 * h[0] * h[2] / 4, 1e-10);
  VectorizedDouble volume, integral;
  fluid::integrate_pressure(cells, volume, integral);
  EXPECT_NEAR(volume[0], 1.5 * h[0] * h[1] * h[2], 1e-20);
  EXPECT_NEAR(integral[0] / volume[0], pressure, 1e-9);
}

TEST_F(Bricks, AnInvertedCellShowsInTheSmallestJacobian) {
  motion[3 * 1][2] = -3 * h[0];
  integrate();
  EXPECT_LT(smallest_J[2], 0);
  EXPECT_GT(smallest_J[1], 0);
}

TEST(Stabilization, HasTheKnownLimits) {
  const double rho = 1060, mu = 3.5e-3, h = 3e-3;
  fem::Mat3<double> G{};
  for (unsigned i = 0; i < 3; ++i)
    G[i][i] = 4 / (h * h); // of a cube
  using fluid::momentum_tau;
  EXPECT_NEAR(momentum_tau(rho, mu, 1e-9, {0, 0, 0}, G) * rho / 1e-9, 1, 1e-9);      // dt / rho
  EXPECT_NEAR(momentum_tau(rho, mu, 1e9, {0, 2., 0}, G) * rho * 2 * 2 / h, 1, 1e-4); // h / (2 rho |u|)
  EXPECT_NEAR(momentum_tau(rho, mu, 1e9, {0, 0, 0}, G) * mu * 4 * std::sqrt(90.) / (h * h), 1, 1e-9);
}

TEST_F(Bricks, AreIntegratedInLittleTime) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "measures a time, which sanitizers lengthen";
#endif
  const auto start = std::chrono::steady_clock::now();
  const int repetitions = 200;
  for (int k = 0; k < repetitions; ++k)
    integrate();
  const std::chrono::duration<double, std::micro> elapsed = std::chrono::steady_clock::now() - start;
  RecordProperty("microseconds_a_cell", std::to_string(elapsed.count() / repetitions / fem::n_lanes));
  EXPECT_LT(elapsed.count() / repetitions / fem::n_lanes, 50);
}

} // namespace
