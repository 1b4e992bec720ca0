// The wall without blood: regions by name, loads in time, nearly incompressible cells.
#include "common/geometry/mesh_tools.h"
#include "lonely_bus.h"
#include "mech_solver/mech_solver.h"
#include "mpi_test_main.h"

#include <spdlog/sinks/null_sink.h>

using namespace heartbus;
using namespace heartbus::mech;

namespace {

constexpr double mu = 12e3, kappa = 50e3, E_strain = kappa + 4 * mu / 3, density = 1000; // E_strain: uniaxial strain

Parameters passive() {
  Parameters parameters;
  parameters.law = "neo_hookean";
  parameters.neo_hookean = {mu, kappa};
  parameters.density = density;
  parameters.active.model = "none";
  parameters.fixed = {};
  parameters.pericardium.labels = {};
  parameters.initial_pressure = 0;
  parameters.solver.residual_tolerance = 1e-10;
  parameters.solver.update_tolerance = 1e-9;
  parameters.solver.linear_tolerance = 1e-6;
  return parameters;
}

/// Between rollers, its foot held: all that happens is along z.
Parameters column() {
  Parameters parameters = passive();
  parameters.rollers = {"x_low", "x_high", "y_low", "y_high"};
  parameters.fixed = {"z_low"};
  parameters.probes["top"] = {0, 0, 10e-3};
  return parameters;
}

geometry::FibreParameters straight() {
  geometry::FibreParameters fibres;
  fibres.rule = "constant";
  return fibres;
}

geometry::Mesh column_mesh() { return geometry::make_box({0, 0, 0}, {5e-3, 5e-3, 10e-3}, {2, 1, 8}); }

struct Wall {
  fem::LagrangeSpace space;
  fem::Fibres fibres;
  MechSolver solver;
  test::LonelyBus bus;
  explicit Wall(const Parameters &parameters, const geometry::Mesh &mesh = column_mesh())
      : space(MPI_COMM_WORLD, mesh), fibres(space, straight()),
        solver(space, fibres, parameters,
               std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::null_sink_mt>())) {
    solver.couple({interface::WallSettings::Load::initial_pressure});
    solver.declare(bus);
    bus.tasks.at("inflate")({});
  }
  void step(int number, double size) {
    const bus::Step step{number, 0, number * size, size};
    solver.prepare_step(step);
    solver.solve_step(step);
    solver.commit_step(step);
  }
  double get(const std::string &scalar) {
    return dealii::Utilities::MPI::sum(bus.scalars.at(scalar)(), MPI_COMM_WORLD);
  }
};

/// A box of two halves, the upper one a region of its own.
geometry::Mesh two_regions() {
  geometry::Mesh mesh = column_mesh();
  mesh.material_names = {"muscle", "ring"};
  mesh.materials.assign(mesh.n_cells(), 0);
  for (unsigned c = 0; c < mesh.n_cells(); ++c)
    mesh.materials[c] = mesh.points[mesh.cells[8 * c]][2] > 4.9e-3;
  return mesh;
}

fem::Vector some_displacement(const fem::LagrangeSpace &space) {
  fem::Vector d = space.make_vector(3);
  for (unsigned k = 0; k < 3 * space.n_owned_nodes(); ++k) {
    const geometry::Point3 &x = space.points()[k / 3];
    d.local_element(k) = 2e-4 * std::sin(400 * (x[0] + 1.7 * x[1] + 2.3 * x[2]) + k % 3);
  }
  return d;
}

/// |K v - (r(d + h v) - r(d - h v)) / 2h| / |K v|, K and r those of all forces.
double tangent_error(const Parameters &parameters, double h) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, column_mesh());
  const fem::Fibres fibres(space, straight());
  ElasticityProblem problem(space, fibres, parameters);
  problem.tension = 20e3;
  const fem::Vector d = some_displacement(space);
  fem::Vector v = space.make_vector(3), Kv = v, right = v, left = v;
  for (unsigned k = 0; k < v.locally_owned_size(); ++k)
    v.local_element(k) = std::cos(1.3 * (k % 3) + 900 * space.points()[k / 3][2]);
  problem.residual(d, right); // brings tension and limits up to date
  problem.linearise(d);
  problem.tangent().vmult(Kv, v);
  fem::Vector moved(d);
  moved.add(h, v);
  problem.residual(moved, right);
  moved.add(-2 * h, v);
  problem.residual(moved, left);
  right -= left;
  right *= 1 / (2 * h);
  right -= Kv;
  return right.l2_norm() / Kv.l2_norm();
}

/// 1/E: a cantilever's deflection goes with it.
double flexibility(double bulk_modulus) { return (3 * bulk_modulus + mu) / (9 * bulk_modulus * mu); }

geometry::Mesh cantilever(unsigned cells) { return geometry::make_box({0, 0, 0}, {10e-3, 1e-3, 1e-3}, {cells, 4, 4}); }

Parameters cantilever(double bulk_modulus, const std::string &volume) {
  Parameters parameters = passive();
  parameters.neo_hookean.kappa = bulk_modulus;
  parameters.volume = volume;
  parameters.inertia = false;
  parameters.fixed = {"x_low"};
  return parameters;
}

/// Deflection of a slender cantilever under a small dead load at its end.
double deflection(const std::string &volume, double bulk_modulus) {
  Parameters parameters = cantilever(bulk_modulus, volume);
  parameters.solver.residual_tolerance = 1e-8; // of what a strain of 1e-5 of the volume would make
  parameters.solver.update_tolerance = 1e-5;
  parameters.loads["pull"] = {"x_high", {}, {0, 0, 50}, {{0}, {1}}};
  parameters.probes["tip"] = {10e-3, 0, 0};
  Wall wall(parameters, cantilever(20));
  return wall.get("tip_z");
}

} // namespace

TEST(WallAlone, APressureInTimePushesAColumnAsItShould) {
  for (const bool inertia : {false, true}) {
    Parameters parameters = column();
    parameters.inertia = inertia;
    parameters.loads["push"] = {"z_high", {{0, 1}, {0, 10}}};
    Wall wall(parameters);
    EXPECT_NEAR(wall.get("top_z"), 0, 1e-15);
    for (int n = 1; n <= 4; ++n) { // so slow that inertia does nothing
      wall.step(n, 0.25);
      EXPECT_NEAR(wall.get("top_z"), -0.25 * n * 10 / E_strain * 10e-3, 1e-3 * 10 / E_strain * 10e-3) << inertia;
    }
  }
}

TEST(WallAlone, TheFirstStepsAfterAnInflationStayWhereItEnded) {
  geometry::Mesh mesh = column_mesh();
  std::replace(mesh.labels.begin(), mesh.labels.end(), std::string("z_high"), std::string("interface"));
  for (const bool as_load : {false, true}) {
    Parameters parameters = column();
    if (as_load)
      parameters.loads["inside"] = {"interface", {{0}, {2e3}}};
    else
      parameters.initial_pressure = 2e3;
    Wall wall(parameters, mesh);
    const double inflated = wall.get("top_z");
    EXPECT_LT(inflated, -2e-4);
    for (int n = 1; n <= 3; ++n)
      wall.step(n, 1e-3);
    EXPECT_NEAR(wall.get("top_z"), inflated, 1e-10) << as_load;
  }
}

TEST(WallAlone, DeadTractionAndGravityMoveAColumnAsTheyShould) {
  Parameters parameters = column();
  parameters.inertia = false;
  parameters.loads["pull"] = {"z_high", {}, {0, 0, 20}, {{0}, {0.5}}};
  const double pulled = 10 / E_strain * 10e-3;
  EXPECT_NEAR(Wall(parameters).get("top_z"), pulled, 2e-3 * pulled);
  parameters.loads.clear();
  parameters.gravity = {0, 0, -9.81};
  const double sunk = density * 9.81 * 10e-3 * 10e-3 / (2 * E_strain); // rho g L^2 / 2 E
  EXPECT_NEAR(Wall(parameters).get("top_z"), -sunk, 2e-3 * sunk);
}

TEST(WallAlone, RegionsHaveALawADensityAndATensionOfTheirOwn) {
  Parameters parameters = column();
  parameters.inertia = false;
  parameters.gravity = {0, 0, -9.81};
  RegionParameters ring{parameters, false};
  ring.neo_hookean = {10 * mu, 10 * kappa};
  ring.density = 2 * density;
  parameters.regions["ring"] = ring;
  // Stress is the weight above: E u' = -g (2 rho (L - z)) in the ring, -g (rho L + rho (L/2 - z)) below.
  const double L = 10e-3, sunk = density * 9.81 * L * L * (5. / 8 / E_strain + 1. / 4 / (10 * E_strain));
  EXPECT_NEAR(Wall(parameters, two_regions()).get("top_z"), -sunk, 3e-3 * sunk);

  parameters.gravity = {0, 0, 0};
  parameters.active.model = "prescribed";
  parameters.active.tension = {{0}, {100}};
  parameters.regions["ring"].contracts = false;
  geometry::FibreParameters along = straight();
  along.direction = {0, 0, 1};
  along.sheet = {1, 0, 0};
  const fem::LagrangeSpace space(MPI_COMM_WORLD, two_regions());
  const fem::Fibres fibres(space, along);
  MechSolver solver(space, fibres, parameters,
                    std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::null_sink_mt>()));
  solver.couple({interface::WallSettings::Load::initial_pressure});
  test::LonelyBus bus;
  solver.declare(bus);
  bus.tasks.at("inflate")({});
  const double top = dealii::Utilities::MPI::sum(bus.scalars.at("top_z")(), MPI_COMM_WORLD),
               shortened = 100 / E_strain * L / 2;
  EXPECT_NEAR(top, -shortened, 5e-3 * shortened) << "the lower half alone contracts";
}

TEST(WallAlone, ARegionThatTheMeshDoesNotHaveIsRefused) {
  Parameters parameters = column();
  parameters.regions["rings"] = {parameters, false};
  for (const auto &[mesh, reason] : {std::pair{two_regions(), "did you mean 'ring'? It has muscle, ring"},
                                     std::pair{column_mesh(), "the mesh has no region 'rings'. It has box"}})
    try {
      Wall wall(parameters, mesh);
      FAIL() << "nothing was refused";
    } catch (const Failure &failure) {
      EXPECT_EQ(failure.code(), ExitCode::scene);
      EXPECT_NE(std::string(failure.what()).find(reason), std::string::npos) << failure.what();
    }
}

TEST(WallAlone, AProbeIsANode) {
  Parameters parameters = column();
  parameters.probes["off"] = {1e-3, 0, 0};
  try {
    Wall wall(parameters);
    FAIL() << "nothing was refused";
  } catch (const Failure &failure) {
    EXPECT_NE(std::string(failure.what()).find("mechanics.probes.off: the wall has no node at (1, 0, 0) mm"),
              std::string::npos)
        << failure.what();
  }
}

TEST(WallAlone, TheTangentOfMeanDilatationIsTheDerivativeOfTheForces) {
  for (const char *law : {"neo_hookean", "guccione"})
    for (const char *measure : {"nominal", "second_piola"}) {
      Parameters parameters = passive();
      parameters.law = law;
      parameters.volume = "mean_dilatation";
      parameters.neo_hookean.kappa = parameters.guccione.kappa = 1e6;
      parameters.active.model = "prescribed";
      parameters.active.measure = measure;
      parameters.loads["push"] = {"z_high", {{0}, {5e3}}};
      const double coarse = tangent_error(parameters, 1e-6), fine = tangent_error(parameters, 1e-7);
      EXPECT_LT(fine, 1e-5) << law;
      EXPECT_NEAR(coarse / fine, 100, 30) << law << ": central differences are of second order";
    }
}

TEST(WallAlone, MeanDilatationIsThePenaltyWhereVolumeChangesEvenly) {
  const auto top = [](const char *volume) {
    Parameters parameters = column();
    parameters.inertia = false;
    parameters.volume = volume;
    parameters.loads["push"] = {"z_high", {{0}, {8e3}}};
    return Wall(parameters).get("top_z");
  };
  EXPECT_NEAR(top("mean_dilatation"), top("penalty"), 1e-9);
  EXPECT_LT(top("penalty"), -1e-3);
}

TEST(WallAlone, MeanDilatationDoesNotLock) {
  const double stiff = 1e6, expected = deflection("mean_dilatation", kappa) * flexibility(stiff) / flexibility(kappa);
  EXPECT_NEAR(deflection("mean_dilatation", stiff), expected, 0.03 * expected);
  EXPECT_LT(deflection("penalty", stiff), 0.8 * expected) << "here locking does not show";
}

TEST(WallAlone, SystemsThatAreBeyondMultigridAreFactorised) {
  for (const auto &[bulk_modulus, preconditioner] : {std::pair(kappa, "amg"), std::pair(1e8, "direct")}) {
    const fem::LagrangeSpace space(MPI_COMM_WORLD, cantilever(40));
    const fem::Fibres fibres(space, straight());
    ElasticityProblem problem(space, fibres, cantilever(bulk_modulus, "mean_dilatation"));
    fem::Vector d = space.make_vector(3), force = d, Kd = d;
    problem.residual(d, force);
    problem.linearise(d);
    for (unsigned k = 0; k < force.locally_owned_size(); ++k)
      force.local_element(k) =
          std::cos(1.3 * (k % 3) + 900 * space.points()[k / 3][2] + 300 * space.points()[k / 3][0]);
    fem::zero_constrained(force, problem.constrained());
    problem.solve_tangent(d, force);
    EXPECT_EQ(problem.tangent_solver().preconditioner_kind(), preconditioner);
    problem.apply_tangent(Kd, d);
    Kd -= force;
    EXPECT_LT(Kd.l2_norm(), 2e-6 * force.l2_norm());
  }
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
