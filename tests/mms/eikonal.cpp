#include "ep_solver/eikonal.h"
#include "common/base/failure.h"
#include "common/geometry/mesh_tools.h"
#include "ep_solver/activation_solver.h"
#include "ep_solver/activation_times.h"
#include "ep_solver/arrival.h"
#include "mpi_test_main.h"

#include <cmath>
#include <filesystem>

using namespace heartbus;
namespace arrival = ep::arrival;
using fem::Mat3;
using geometry::Point3;

namespace {

constexpr double start = 2e-3; // [s]
constexpr double c = 60;       // [s^-1/2]

double largest(double x, MPI_Comm communicator = MPI_COMM_WORLD) {
  return dealii::Utilities::MPI::max(x, communicator);
}

/// Fibres across all axes; speeds of 0.78, 0.53 and 0.3 m/s.
Mat3<double> oblique() {
  const double f[3] = {0.6, 0.64, 0.48}, s[3] = {0.8, -0.48, -0.36}, n[3] = {0, 0.6, -0.8};
  Mat3<double> D{};
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      D[i][j] = 1.68e-4 * f[i] * f[j] + 0.769e-4 * s[i] * s[j] + 0.248e-4 * n[i] * n[j];
  return D;
}

Mat3<double> isotropic() { return 1e-4 * fem::identity<double>(); }

std::vector<Mat3<fem::VectorizedDouble>> everywhere(const fem::LagrangeSpace &space, const Mat3<double> &D) {
  Mat3<fem::VectorizedDouble> lanes;
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      lanes[i][j] = fem::lanes(D[i][j]);
  return std::vector<Mat3<fem::VectorizedDouble>>(space.n_batches() * space.n_q(), lanes);
}

enum class Cells { hexahedra, linear_tetrahedra, quadratic_tetrahedra };

geometry::Mesh box(const Point3 &size, const std::array<unsigned, 3> &n, Cells cells) {
  const geometry::Mesh mesh = geometry::make_box({0, 0, 0}, size, n);
  return cells == Cells::hexahedra ? mesh : geometry::make_tetrahedra(mesh);
}

fem::LagrangeSpace space_of(const geometry::Mesh &mesh, Cells cells, MPI_Comm communicator = MPI_COMM_WORLD) {
  return fem::LagrangeSpace(communicator, mesh, 0, cells == Cells::quadratic_tetrahedra ? 2 : 1);
}

/// The largest difference of times from what `exact` says, where it says something [s].
double error(const fem::LagrangeSpace &space, const std::vector<double> &times,
             const std::function<double(const Point3 &)> &exact) {
  double error = 0;
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
    if (const double wanted = exact(space.points()[node]); !std::isnan(wanted))
      error = std::max(error, std::abs(times[node] - wanted));
  return largest(error, space.communicator());
}

const Cells all_cells[] = {Cells::hexahedra, Cells::linear_tetrahedra, Cells::quadratic_tetrahedra};

} // namespace

/// Under a plane wave of slowness p, p . V p = 1, times are linear, and those at the corners give that at x wherever
/// the ray to x comes through the triangle.
TEST(Arrival, OfAPlaneWaveIsExact) {
  const Mat3<double> V = c * c * oblique();
  const ep::Metric metric(V);
  const std::array<arrival::Vector, 3> ways{{{1e-3, 1e-3, 3e-3}, {-1e-3, 1e-3, 3e-3}, {0, -2e-3, 3e-3}}};
  const arrival::Vector ray{0.1, -0.05, 1}; // through the plane of the triangle, 3 mm below x, within it
  arrival::Vector p = fem::inverse(V) * ray;
  const double size = std::sqrt(fem::dot(p, V * p));
  for (double &x : p)
    x /= size;
  std::array<double, 3> times;
  std::array<arrival::Vector, 3> from;
  for (unsigned k = 0; k < 3; ++k) {
    times[k] = 0.05 - fem::dot(p, ways[k]);
    from[k] = metric(ways[k]);
  }
  EXPECT_NEAR(arrival::from_triangle(from, times), 0.05, 1e-15);
  times[2] = arrival::never;
  const double by_the_edge = arrival::from_triangle(from, times);
  EXPECT_GT(by_the_edge, 0.05);
  EXPECT_LE(by_the_edge, std::min(arrival::from_corner(from[0], times[0]), arrival::from_corner(from[1], times[1])));
  EXPECT_EQ(arrival::from_triangle(from, {times[2], times[2], times[2]}), arrival::never);
}

/// From one end of a bar with oblique fibres: T = x / sqrt(V_xx) where the ray from that end stays within the bar and
/// nothing from the sides, two or three cells further in with each layer of cells, can have come; elsewhere not
/// earlier.
TEST(Eikonal, PlaneFrontInABarWithObliqueFibresIsExact) {
  const Mat3<double> D = oblique();
  const double speed = c * std::sqrt(D[0][0]);
  for (const Cells cells : all_cells) {
    const bool quadratic = cells == Cells::quadratic_tetrahedra;
    const geometry::Mesh mesh = box(
        {8e-3, 24e-3, 24e-3}, quadratic ? std::array<unsigned, 3>{2, 6, 6} : std::array<unsigned, 3>{4, 12, 12}, cells);
    const fem::LagrangeSpace space = space_of(mesh, cells);
    const auto times = ep::eikonal(space, everywhere(space, D), c, {{"cube", {-50e-3, 0, 0}, 50e-3}}, start);
    double exact_nodes = 0;
    const auto exact = [&](const Point3 &x) {
      const double y = x[1] - x[0] * D[1][0] / D[0][0], z = x[2] - x[0] * D[2][0] / D[0][0]; // where the ray begins
      const double margin = std::min({y, z, 24e-3 - y, 24e-3 - z, x[1], x[2], 24e-3 - x[1], 24e-3 - x[2]});
      const bool within = margin >= 2.5 * x[0];
      exact_nodes += within && x[0] > 0;
      return within ? start + x[0] / speed : std::nan("");
    };
    EXPECT_LT(error(space, times, exact), 1e-9) << int(cells); // what is not worth passing on, a few times
    EXPECT_GT(dealii::Utilities::MPI::sum(exact_nodes, MPI_COMM_WORLD), 30);
    double earliest = 1; // no node is reached before a plane front would
    for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
      earliest = std::min(earliest, times[node] - start - space.points()[node][0] / speed);
    EXPECT_GE(earliest, -1e-12);
  }
}

/// T = start + (distance from the ball) / speed, of first order.
TEST(Eikonal, DistanceFromABallIsOfFirstOrder) {
  const double speed = c * std::sqrt(1e-4);
  for (const Cells cells : all_cells) {
    double errors[2];
    for (const unsigned k : {0u, 1u}) {
      const unsigned n = (cells == Cells::quadratic_tetrahedra ? 3 : 6) << k;
      const geometry::Mesh mesh = box({20e-3, 20e-3, 20e-3}, {n, n, n}, cells);
      const fem::LagrangeSpace space = space_of(mesh, cells);
      const auto times =
          ep::eikonal(space, everywhere(space, isotropic()), c, {{"ball", {4e-3, 5e-3, 6e-3}, 5e-3}}, start);
      errors[k] = error(space, times, [&](const Point3 &x) {
        const double r = std::hypot(x[0] - 4e-3, x[1] - 5e-3, x[2] - 6e-3);
        return start + std::max(0., r - 4.5e-3) / speed;
      });
    }
    EXPECT_GT(std::log2(errors[0] / errors[1]), 0.6);
    EXPECT_LT(errors[1], 1.5e-3); // of 40 ms
  }
}

/// In a convex body the front takes straight ways: T = start + the smallest |x - y|_M to a point y of the site. The
/// error falls with the mesh.
TEST(Eikonal, AnisotropicDistanceFromACube) {
  const ep::Metric metric(c * c * oblique());
  const auto exact = [&](const Point3 &x) {
    double nearest = 1;
    for (double i = 0; i <= 2e-3; i += 0.5e-3)
      for (double j = 0; j <= 2e-3; j += 0.5e-3)
        for (double k = 0; k <= 2e-3; k += 0.5e-3)
          nearest = std::min(nearest, arrival::from_corner(metric({x[0] - i, x[1] - j, x[2] - k}), start));
    return nearest;
  };
  for (const Cells cells : all_cells) {
    double errors[2];
    for (const unsigned k : {0u, 1u}) {
      const unsigned n = (cells == Cells::quadratic_tetrahedra ? 4 : 8) << k;
      const geometry::Mesh mesh = box({16e-3, 16e-3, 16e-3}, {n, n, n}, cells);
      const fem::LagrangeSpace space = space_of(mesh, cells);
      errors[k] =
          error(space, ep::eikonal(space, everywhere(space, oblique()), c, {{"cube", {0, 0, 0}, 2e-3}}, start), exact);
    }
    EXPECT_GT(std::log2(errors[0] / errors[1]), 0.5);
    EXPECT_LT(errors[1], 4e-3); // of 50 ms
  }
}

TEST(Eikonal, DoesNotDependOnRanks) {
  for (const Cells cells : all_cells) {
    const geometry::Mesh mesh = box({10e-3, 8e-3, 6e-3}, {10, 8, 6}, cells);
    const fem::LagrangeSpace space = space_of(mesh, cells), alone = space_of(mesh, cells, MPI_COMM_SELF);
    const std::vector<ep::StimulusSite> sites{{"ball", {0, 0, 0}, 2e-3}, {"cube", {10e-3, 8e-3, 3e-3}, 1e-3}};
    const auto times = ep::eikonal(space, everywhere(space, oblique()), c, sites, start),
               there = ep::eikonal(alone, everywhere(alone, oblique()), c, sites, start);
    double found = 0;
    for (unsigned i = 0; i < space.n_owned_nodes(); ++i)
      for (unsigned k = 0; k < alone.n_owned_nodes(); ++k)
        if (space.points()[i] == alone.points()[k]) {
          EXPECT_NEAR(times[i], there[k], 2e-9);
          ++found;
        }
    EXPECT_EQ(found, space.n_owned_nodes());
  }
}

TEST(Eikonal, ASiteThatReachesNoNodeIsRefused) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, geometry::make_box({0, 0, 0}, {4e-3, 4e-3, 4e-3}, {4, 4, 4}));
  try {
    ep::eikonal(space, everywhere(space, isotropic()), c,
                {{"ball", {0, 0, 0}, 2e-3}, {"ball", {0.5e-3, 0.5e-3, -1e-3}, 1e-3}}, start);
    FAIL();
  } catch (const Failure &failure) {
    EXPECT_EQ(failure.code(), ExitCode::scene);
    EXPECT_NE(std::string(failure.what()).find("site 2, a ball of radius 1 mm"), std::string::npos) << failure.what();
  }
}

namespace {

struct Wall {
  fem::LagrangeSpace space;
  ep::Parameters parameters;
  std::unique_ptr<ep::IonicModel> cell = ep::make_ionic_model("bueno_orovio_epi");
  explicit Wall(unsigned n = 4) : space(MPI_COMM_WORLD, geometry::make_box({0, 0, 0}, {4e-3, 4e-3, 4e-3}, {n, n, n})) {}
  std::vector<double> rising() const { ///< 10 ms and more
    std::vector<double> times;
    for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
      times.push_back(10e-3 + space.points()[node][0] + space.points()[node][1] / 3);
    return times;
  }
};

std::string complaint(ExitCode code, const std::function<void()> &action) {
  try {
    action();
  } catch (const Failure &failure) {
    EXPECT_EQ(failure.code(), code) << failure.what();
    return failure.what();
  }
  return "";
}

} // namespace

/// Calcium is that of the cell since the node's activation, beat after beat, from any step on.
TEST(Activation, EachNodePassesThroughTheBeatOfTheCell) {
  Wall wall;
  std::vector<double> times = wall.rising();
  const bool has_node = !times.empty();
  if (has_node)
    times[0] = std::nan("");
  ep::ActivationSolver solver(wall.space, times, *wall.cell, wall.parameters);
  const ep::Transient cell(*wall.cell, "limit_cycle", 0.8);
  for (const double time : {1e-3, 50e-3, 0.4, 0.8, 0.85, 1.65}) {
    solver.solve_step({1, 0, time, 1e-3});
    for (unsigned node = 0; node < times.size(); ++node)
      EXPECT_EQ(solver.calcium()[node], cell.calcium(time - times[node]));
  }
  ep::ActivationSolver again(wall.space, times, *wall.cell, wall.parameters);
  again.load_state("", {1650, 0, 1.65, 1e-3});
  EXPECT_EQ(again.calcium(), solver.calcium());
}

TEST(Activation, CalciumMayBePrescribed) {
  Wall wall;
  wall.parameters.model = "prescribed";
  wall.parameters.prescribed.calcium = {{0, 0.1, 0.5}, {0.1, 1.1, 0.1}};
  geometry::FibreParameters fibres;
  fibres.rule = "constant";
  const auto times = ep::activation_times(wall.space, fem::Fibres(wall.space, fibres), *wall.cell, wall.parameters);
  ep::ActivationSolver solver(wall.space, times, *wall.cell, wall.parameters);
  for (const auto &[time, calcium] : {std::pair(0.05, 0.6), {0.3, 0.6}, {0.7, 0.1}, {0.85, 0.6}}) {
    solver.solve_step({1, 0, time, 1e-3});
    for (const double value : solver.calcium())
      EXPECT_NEAR(value, calcium, 1e-9);
  }
}

/// What a run leaves is what another takes, on a mesh whose nodes it has.
TEST(Activation, TimesComeFromTheMapOfAnotherRun) {
  Wall fine(8), coarse(4), other(3);
  const std::string folder =
      testing::TempDir() + "activation_on_" + std::to_string(dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD));
  if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
    std::filesystem::create_directories(folder);
  MPI_Barrier(MPI_COMM_WORLD);
  OutputParameters output;
  output.every = 0;
  ep::ActivationSolver solver(fine.space, fine.rising(), *fine.cell, fine.parameters);
  solver.write_fields(folder, output);
  solver.finish();
  const std::string file = folder + "/activation.h5";
  EXPECT_EQ(ep::activation_times_of_file(fine.space, file), fine.rising());
  const auto times = ep::activation_times_of_file(coarse.space, file);
  for (unsigned node = 0; node < times.size(); ++node)
    EXPECT_NEAR(times[node], coarse.rising()[node], 1e-12);
  EXPECT_NE(
      complaint(ExitCode::map, [&] { ep::activation_times_of_file(other.space, file); }).find("the mesh of " + file),
      std::string::npos);
  EXPECT_NE(
      complaint(ExitCode::file, [&] { ep::activation_times_of_file(fine.space, folder + "/none.h5"); }).find("none.h5"),
      std::string::npos);
  EXPECT_NE(complaint(ExitCode::file, [&] { ep::activation_times_of_file(fine.space, folder + "/activation.xdmf"); })
                .find("activation.xdmf"),
            std::string::npos);
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
