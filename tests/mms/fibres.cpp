#include "common/fibres/fibres.h"
#include "common/base/failure.h"
#include "common/geometry/mesh_tools.h"
#include "common/geometry/shapes.h"
#include "mpi_test_main.h"

#include <algorithm>
#include <cmath>
#include <map>

using namespace heartbus;
using fem::n_lanes;
using geometry::Point3;

namespace {

/// Column `i` of the frame: 0 f, 1 s, 2 n.
Point3 column(const fem::Fibres &fibres, unsigned slot, unsigned q, unsigned i) {
  const auto &frame = fibres.frames(slot / n_lanes)[q];
  const unsigned lane = slot % n_lanes;
  return {frame[0][i][lane], frame[1][i][lane], frame[2][i][lane]};
}

template <class Visit>
void for_each_owned_point(const fem::LagrangeSpace &space, const Visit &visit) {
  for (unsigned slot = 0; slot < space.n_slots(); ++slot)
    for (unsigned q = 0; q < space.n_q() && space.slot_owned(slot); ++q)
      visit(slot, q);
}

double largest(double x) { return dealii::Utilities::MPI::max(x, MPI_COMM_WORLD); }

geometry::Mesh ventricle(const std::string &cells = "hexahedra", const std::string &mesh = "M0") {
  geometry::Parameters parameters;
  parameters.cells = cells;
  parameters.mesh = mesh;
  return geometry::make_solid(parameters);
}

geometry::FibreParameters by_rule(const std::string &rule) {
  geometry::FibreParameters parameters;
  parameters.rule = rule;
  return parameters;
}

/// By 50 degrees around x.
Point3 tilted(const Point3 &x) {
  const double c = std::cos(5 * M_PI / 18), s = std::sin(5 * M_PI / 18);
  return {x[0], c * x[1] - s * x[2], s * x[1] + c * x[2]};
}

/// A flat wall of 10 mm: endocardium x = 0, epicardium x = 10 mm.
geometry::Mesh flat_wall() {
  geometry::Mesh mesh = geometry::make_box({0, 0, 0}, {10e-3, 8e-3, 6e-3}, {5, 3, 3});
  mesh.labels[0] = "interface";
  mesh.labels[1] = "epicardium";
  return mesh;
}

} // namespace

TEST(Fibres, TurnLinearlyThroughAFlatWall) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, flat_wall());
  const geometry::FibreParameters parameters;
  const fem::Fibres fibres(space, parameters);
  for_each_owned_point(space, [&](unsigned slot, unsigned q) {
    // e_t = x, k = z: e_n = z, e_l = y.
    const double depth = space.quadrature_point(slot, q)[0] / 10e-3;
    const double theta = (1 - depth) * parameters.angle_endo + depth * parameters.angle_epi;
    const Point3 f = column(fibres, slot, q, 0), s = column(fibres, slot, q, 1), n = column(fibres, slot, q, 2);
    const Point3 wanted_f{0, std::cos(theta), std::sin(theta)}, wanted_n{0, std::sin(theta), -std::cos(theta)};
    for (unsigned i = 0; i < 3; ++i) {
      EXPECT_NEAR(f[i], wanted_f[i], 1e-9);
      EXPECT_NEAR(s[i], i == 0, 1e-9);
      EXPECT_NEAR(n[i], wanted_n[i], 1e-9);
    }
  });
}

namespace {

double worst_frame(const fem::LagrangeSpace &space, const fem::Fibres &fibres) {
  double worst = 0;
  for (unsigned batch = 0; batch < space.n_batches(); ++batch)
    for (unsigned q = 0; q < space.n_q(); ++q) {
      const auto &R = fibres.frames(batch)[q];
      const auto RtR = fem::transpose(R) * R;
      for (unsigned lane = 0; lane < n_lanes; ++lane) {
        worst = std::max(worst, std::abs(fem::determinant(R)[lane] - 1));
        for (unsigned i = 0; i < 3; ++i)
          for (unsigned j = 0; j < 3; ++j)
            worst = std::max(worst, std::abs(RtR[i][j][lane] - (i == j)));
      }
    }
  return largest(worst); // not a number fails too
}

} // namespace

TEST(Fibres, FramesAreOrthonormalAndRightHandedEverywhereInTheVentricle) {
  for (const auto &[cells, degree] :
       {std::pair("hexahedra", 1u), std::pair("tetrahedra", 1u), std::pair("tetrahedra", 2u)}) {
    const fem::LagrangeSpace space(MPI_COMM_WORLD, ventricle(cells), 0, degree);
    for (const char *rule : {"transmural", "apicobasal"})
      EXPECT_LT(worst_frame(space, fem::Fibres(space, by_rule(rule))), 1e-12) << cells << degree << rule;
  }
}

/// In the corners of this cup are cells with all vertices on the endocardium, without a transmural gradient of their
/// own.
TEST(Fibres, AreLaidInCellsWithAllVerticesOnOneSide) {
  geometry::Mesh mesh = flat_wall();
  for (auto &face : mesh.faces)
    face.label = face.label == 1;
  mesh.labels = {"interface", "epicardium"};
  const fem::LagrangeSpace space(MPI_COMM_WORLD, geometry::make_tetrahedra(mesh));
  const auto endo = space.nodes_on("interface");
  double n_flat = 0;
  for (unsigned slot = 0; slot < space.n_slots(); ++slot)
    n_flat += space.slot_owned(slot) && std::all_of(space.cell_nodes(slot), space.cell_nodes(slot) + 4,
                                                    [&](unsigned node) { return endo[node]; });
  EXPECT_GT(dealii::Utilities::MPI::sum(n_flat, MPI_COMM_WORLD), 0);
  EXPECT_LT(worst_frame(space, fem::Fibres(space, {})), 1e-12);
}

namespace {

/// Mean angle [degrees] between the fibres of the general and of the special rule where they do not disperse, and the
/// largest difference of the dispersed share.
std::pair<double, double> differences_of_rules(const char *mesh) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, ventricle("hexahedra", mesh));
  const fem::Fibres special(space, by_rule("transmural")), general(space, by_rule("apicobasal"));
  double angles = 0, n = 0, worst_share = 0;
  for_each_owned_point(space, [&](unsigned slot, unsigned q) {
    const Point3 a = column(special, slot, q, 0), b = column(general, slot, q, 0), s = column(special, slot, q, 1);
    const double share = special.dispersion(slot / n_lanes)[q][slot % n_lanes];
    worst_share = std::max(worst_share, std::abs(share - general.dispersion(slot / n_lanes)[q][slot % n_lanes]));
    if (std::hypot(s[0], s[1]) > std::sin(M_PI / 6)) {
      angles += std::acos(std::min(1., a[0] * b[0] + a[1] * b[1] + a[2] * b[2])) * 180 / M_PI;
      ++n;
    }
  });
  return {dealii::Utilities::MPI::sum(angles, MPI_COMM_WORLD) / dealii::Utilities::MPI::sum(n, MPI_COMM_WORLD),
          largest(worst_share)};
}

} // namespace

/// On the ventricle with a flat base, the general rule lays the fibres of the special one, the better the finer the
/// mesh: on the edges of the O-grid three cells meet, and gradients are rough there.
TEST(Fibres, BetweenApexAndRingsAreThoseBelowAFlatBase) {
  const auto coarse = differences_of_rules("MXS"), fine = differences_of_rules("M0");
  EXPECT_LT(fine.first, 2);
  EXPECT_LT(fine.first, 0.7 * coarse.first);
  EXPECT_LT(fine.second, 0.03);
}

TEST(Fibres, BetweenApexAndRingsTurnWithTheBody) {
  geometry::Mesh mesh = ventricle("tetrahedra"), turned = mesh;
  std::transform(mesh.points.begin(), mesh.points.end(), turned.points.begin(), tilted);
  const fem::LagrangeSpace space(MPI_COMM_WORLD, mesh), turned_space(MPI_COMM_WORLD, turned);
  const fem::Fibres fibres(space, by_rule("apicobasal")), turned_fibres(turned_space, by_rule("apicobasal"));
  for_each_owned_point(space, [&](unsigned slot, unsigned q) {
    const Point3 s = column(fibres, slot, q, 1);
    for (unsigned i = 0; i < 2 && std::hypot(s[0], s[1]) > 0.05; ++i) {
      const Point3 wanted = tilted(column(fibres, slot, q, i)), found = column(turned_fibres, slot, q, i);
      for (unsigned c = 0; c < 3; ++c)
        EXPECT_NEAR(found[c], wanted[c], 1e-6);
    }
  });
}

/// In a flat wall w = cosh(z / l) / cosh(H / l): no flux below, 1 on the ring at the top.
TEST(Fibres, TurnIntoThoseOfTheOutflowTract) {
  geometry::Mesh mesh = geometry::make_box({0, 0, 0}, {10e-3, 4e-3, 40e-3}, {4, 1, 40});
  mesh.labels = {"interface", "epicardium", "a", "b", "low", "ring"};
  const fem::LagrangeSpace space(MPI_COMM_WORLD, mesh);
  geometry::FibreParameters parameters = by_rule("apicobasal");
  parameters.rings = parameters.outflow.rings = {"ring"};
  const fem::Fibres fibres(space, parameters);
  for_each_owned_point(space, [&](unsigned slot, unsigned q) {
    const Point3 x = space.quadrature_point(slot, q), f = column(fibres, slot, q, 0);
    const double depth = x[0] / 10e-3, w = std::cosh(x[2] / 10e-3) / std::cosh(4.), third = M_PI / 3;
    const double theta = ((1 - w) * third + w * M_PI / 2) * (1 - depth) - (1 - w) * third * depth;
    EXPECT_NEAR(std::atan2(f[2], f[1]), theta, 0.003);
  });
}

TEST(Fibres, FormARightHandedHelixOnTheEndocardiumAndALeftHandedOneOnTheEpicardium) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, ventricle(), 1);
  const fem::Fibres fibres(space, {});
  // Near the widest section: z against the circumference y of a point on the x axis (e_t = x, e_n = z, e_l = y).
  double endo = -1e300, epi = -1e300;
  for_each_owned_point(space, [&](unsigned slot, unsigned q) {
    const Point3 x = space.quadrature_point(slot, q), f = column(fibres, slot, q, 0), s = column(fibres, slot, q, 1);
    const double r = std::hypot(x[0], x[1]);
    if (std::abs(x[2]) > 4e-3)
      return;
    EXPECT_GT((s[0] * x[0] + s[1] * x[1]) / r, 0.9) << "sheets point outwards";
    const double around = (f[1] * x[0] - f[0] * x[1]) / r, angle = std::atan2(f[2], around) * 180 / M_PI;
    if (r < 22.5e-3)
      endo = std::max(endo, std::abs(angle - 60));
    if (r > 31.3e-3)
      epi = std::max(epi, std::abs(angle + 60));
  });
  EXPECT_LT(largest(endo), 10); // quadrature points lie up to 0.9 mm from the surface: 120 deg / 10 mm
  EXPECT_LT(largest(epi), 10);
  EXPECT_GE(largest(endo), 0) << "no point near the endocardium was visited";
  EXPECT_GE(largest(epi), 0) << "no point near the epicardium was visited";
}

TEST(Fibres, DisperseEvenlyOnTheAxisAndNotAtAllAwayFromTheApex) {
  geometry::Parameters fine;
  fine.mesh = "M1";
  const fem::LagrangeSpace space(MPI_COMM_WORLD, geometry::make_solid(fine));
  const fem::Fibres fibres(space, {});
  // What a tension acts along, H = (1 - nu) f f + nu n n, against (I - s s) / 2, which has no direction in the wall.
  double on_axis = -1, away = -1;
  for_each_owned_point(space, [&](unsigned slot, unsigned q) {
    const Point3 f = column(fibres, slot, q, 0), s = column(fibres, slot, q, 1), n = column(fibres, slot, q, 2);
    const double nu = fibres.dispersion(slot / n_lanes)[q][slot % n_lanes];
    EXPECT_GE(nu, 0);
    EXPECT_LE(nu, 0.5);
    double difference = 0;
    for (unsigned i = 0; i < 3; ++i)
      for (unsigned j = 0; j < 3; ++j)
        difference =
            std::max(difference, std::abs((1 - nu) * f[i] * f[j] + nu * n[i] * n[j] - ((i == j) - s[i] * s[j]) / 2));
    const double tilt = std::asin(std::min(1., std::hypot(s[0], s[1]))); // of the wall's normal, from the axis
    if (tilt < M_PI / 18)
      on_axis = std::max(on_axis, difference);
    if (tilt > M_PI / 6)
      away = std::max(away, nu);
  });
  EXPECT_GE(largest(on_axis), 0) << "no point near the axis was visited";
  EXPECT_LT(largest(on_axis), 0.12); // x < 0.35 there, 1/2 - nu = x^2 (1 - x^2/2); 1/2 without dispersion
  EXPECT_EQ(largest(away), 0);
}

TEST(Fibres, DoNotDependOnThePartition) {
  const fem::LagrangeSpace together(MPI_COMM_WORLD, ventricle()), alone(MPI_COMM_SELF, ventricle());
  const fem::Fibres fibres(together, {}), reference(alone, {});
  // Both find the same cells in another order: compare by the coordinates of quadrature points.
  std::map<std::array<long, 3>, std::pair<unsigned, unsigned>> where;
  const auto key = [](const Point3 &x) {
    return std::array<long, 3>{std::lround(x[0] * 1e9), std::lround(x[1] * 1e9), std::lround(x[2] * 1e9)};
  };
  for_each_owned_point(alone, [&](unsigned slot, unsigned q) {
    where[key(alone.quadrature_point(slot, q))] = {slot, q};
  });
  double worst = 0, found = 0;
  for_each_owned_point(together, [&](unsigned slot, unsigned q) {
    const auto other = where.find(key(together.quadrature_point(slot, q)));
    if (other == where.end()) // rounded to another nanometre
      return;
    ++found;
    for (unsigned i = 0; i < 3; ++i)
      for (unsigned c = 0; c < 3; ++c)
        worst = std::max(worst, std::abs(column(fibres, slot, q, i)[c] -
                                         column(reference, other->second.first, other->second.second, i)[c]));
  });
  EXPECT_LT(largest(worst), 1e-7);
  EXPECT_GT(dealii::Utilities::MPI::sum(found, MPI_COMM_WORLD), 0.9 * 8 * double(together.n_global_cells()));
}

TEST(Fibres, AtNodesAreUnitVectorsTangentToTheWall) {
  const fem::LagrangeSpace space(MPI_COMM_WORLD, flat_wall());
  const fem::Fibres fibres(space, {});
  const auto &f = fibres.nodal_fibres();
  ASSERT_EQ(f.size(), 3 * space.n_owned_nodes());
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node) {
    EXPECT_NEAR(f[3 * node] * f[3 * node] + f[3 * node + 1] * f[3 * node + 1] + f[3 * node + 2] * f[3 * node + 2], 1,
                1e-12);
    EXPECT_NEAR(f[3 * node], 0, 1e-9);
    const double depth = space.points()[node][0] / 10e-3;
    if (depth > 0.1 && depth < 0.9) { // an even patch around an inner node
      EXPECT_NEAR(std::atan2(f[3 * node + 2], f[3 * node + 1]), M_PI / 3 * (1 - 2 * depth), 1e-6);
    }
  }
}

TEST(Fibres, OfTheConstantRuleFollowTheGivenDirection) {
  geometry::Parameters slab;
  slab.shape = "slab";
  slab.slab.cell = 3e-3;
  const fem::LagrangeSpace space(MPI_COMM_WORLD, geometry::make_solid(slab));
  geometry::FibreParameters parameters;
  parameters.rule = "constant";
  parameters.direction = {0, 3, 0};
  parameters.sheet = {1, 5, 0}; // made orthogonal
  const fem::Fibres fibres(space, parameters);
  for_each_owned_point(space, [&](unsigned slot, unsigned q) {
    EXPECT_EQ(column(fibres, slot, q, 0), (Point3{0, 1, 0}));
    EXPECT_NEAR(column(fibres, slot, q, 1)[0], 1, 1e-14);
    EXPECT_NEAR(column(fibres, slot, q, 2)[2], -1, 1e-14);
  });
}

TEST(Fibres, OfTheRuleFileAreThoseOfTheMesh) {
  geometry::Mesh mesh = flat_wall();
  geometry::FibreParameters parameters;
  parameters.rule = "file";
  EXPECT_THROW(fem::Fibres(fem::LagrangeSpace(MPI_COMM_WORLD, mesh), parameters), Failure);
  mesh.fibres.assign(mesh.n_cells(), {Point3{0, 0.6, 0.8}, Point3{1, 0, 0}});
  const fem::LagrangeSpace space(MPI_COMM_WORLD, mesh, 1);
  const fem::Fibres fibres(space, parameters);
  for_each_owned_point(space, [&](unsigned slot, unsigned q) {
    EXPECT_NEAR(column(fibres, slot, q, 0)[2], 0.8, 1e-14);
    EXPECT_NEAR(column(fibres, slot, q, 1)[0], 1, 1e-14);
    EXPECT_NEAR(column(fibres, slot, q, 2)[1], 0.8, 1e-14);
    EXPECT_EQ(fibres.dispersion(slot / n_lanes)[q][slot % n_lanes], 0);
  });
}

TEST(Fibres, OfTheTransmuralRuleNeedAnEpicardium) {
  geometry::Parameters slab;
  slab.shape = "slab";
  slab.slab.cell = 3e-3;
  const fem::LagrangeSpace space(MPI_COMM_WORLD, geometry::make_solid(slab));
  EXPECT_THROW(fem::Fibres(space, {}), Failure);
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
