#include "common/base/failure.h"
#include "common/geometry/mesh_tools.h"
#include "common/geometry/shapes.h"
#include "scene/scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

using namespace heartbus;
using namespace heartbus::geometry;

namespace {

constexpr double pi = 3.14159265358979323846;

Parameters shape(const std::string &name, const std::string &mesh = "M0") {
  Parameters p;
  p.shape = name;
  p.mesh = mesh;
  return p;
}

/// Below the plane z = h: r^2 = a^2 (1 - z^2/c^2).
double truncated_ellipsoid(double a, double c, double h) {
  const auto primitive = [c](double z) { return z - z * z * z / (3 * c * c); };
  return pi * a * a * (primitive(h) - primitive(-c));
}

std::set<Point3> points_on(const Mesh &mesh, const std::string &label) {
  std::set<Point3> points;
  for (const auto &face : mesh.faces)
    if (mesh.labels[face.label] == label)
      for (unsigned v = 0; v < mesh.vertices_per_face(); ++v)
        points.insert(mesh.points[face.vertices[v]]);
  return points;
}

std::set<std::string> labels_in_use(const Mesh &mesh) {
  std::set<std::string> labels;
  for (const auto &face : mesh.faces)
    labels.insert(mesh.labels[face.label]);
  return labels;
}

} // namespace

TEST(Geometry, LabelsAreKnownWithoutTheMesh) {
  const auto sorted = [](std::vector<std::string> labels) {
    std::sort(labels.begin(), labels.end());
    return labels;
  };
  Parameters p;
  for (const char *shape : {"ideal_left_ventricle", "piston", "slab", "tube"}) {
    p.shape = shape;
    EXPECT_EQ(sorted(solid_labels(p)), sorted(make_solid(p).labels)) << shape;
    if (p.shape != "slab") {
      EXPECT_EQ(sorted(fluid_labels(p)), sorted(make_fluid(p).labels)) << shape;
    }
  }
  p.shape = "slab";
  EXPECT_TRUE(fluid_labels(p).empty());
}

TEST(IdealVentricle, VolumesConvergeToTheTruncatedEllipsoidWithOrderTwo) {
  const double cavity = truncated_ellipsoid(22e-3, 62e-3, 15e-3),
               wall = truncated_ellipsoid(32e-3, 72e-3, 15e-3) - cavity;
  std::map<std::string, double> cavity_error, wall_error;
  for (const std::string mesh : {"M1", "M3"}) {
    cavity_error[mesh] = 1 - volume(make_fluid(shape("ideal_left_ventricle", mesh))) / cavity;
    wall_error[mesh] = 1 - volume(make_solid(shape("ideal_left_ventricle", mesh))) / wall;
  }
  EXPECT_LT(std::abs(cavity_error["M1"]), 0.01);
  EXPECT_LT(std::abs(wall_error["M1"]), 0.01);
  EXPECT_NEAR(std::log2(cavity_error["M1"] / cavity_error["M3"]), 2, 0.1);
  EXPECT_NEAR(std::log2(wall_error["M1"] / wall_error["M3"]), 2, 0.1);
}

TEST(IdealVentricle, SolidAndFluidShareTheEndocardiumBitByBit) {
  for (const std::string mesh : {"MXS", "M0", "M1", "M2"}) {
    const Mesh solid = make_solid(shape("ideal_left_ventricle", mesh)),
               fluid = make_fluid(shape("ideal_left_ventricle", mesh));
    EXPECT_EQ(points_on(solid, "interface"), points_on(fluid, "interface")) << mesh;
    EXPECT_EQ(area(solid, "interface"), area(fluid, "interface")) << mesh;
  }
}

TEST(IdealVentricle, EveryMeshIsValidAndOfThePublishedSize) {
  // Solid and fluid cells; M1 to M3 from the table of meshes of Bucelli, Gabriel, Gigante, Quarteroni, Vergara.
  const std::map<std::string, std::pair<double, double>> wanted{
      {"MXS", {100, 80}}, {"M0", {624, 492}}, {"M1", {6612, 4684}}, {"M2", {22396, 13780}}, {"M3", {51364, 32628}}};
  for (const auto &[mesh, cells] : wanted) {
    const Mesh solid = make_solid(shape("ideal_left_ventricle", mesh)),
               fluid = make_fluid(shape("ideal_left_ventricle", mesh));
    EXPECT_NO_THROW(check(solid)) << mesh;
    EXPECT_NO_THROW(check(fluid)) << mesh;
    EXPECT_NEAR(solid.n_cells() / cells.first, 1, 0.15) << mesh;
    EXPECT_NEAR(fluid.n_cells() / cells.second, 1, 0.15) << mesh;
    EXPECT_EQ(labels_in_use(solid), (std::set<std::string>{"interface", "epicardium", "base"})) << mesh;
    EXPECT_EQ(labels_in_use(fluid), (std::set<std::string>{"interface", "base", "mitral", "aortic"})) << mesh;
  }
}

TEST(IdealVentricle, TheBaseIsFlatAndTheApexPointsDown) {
  const Mesh solid = make_solid(shape("ideal_left_ventricle", "MXS"));
  for (const auto &x : points_on(solid, "base"))
    EXPECT_EQ(x[2], 15e-3);
  double lowest = 0;
  for (const auto &x : solid.points)
    lowest = std::min(lowest, x[2]);
  EXPECT_NEAR(lowest, -72e-3, 1e-12);
}

TEST(IdealVentricle, ValvesHaveTheAreaOfTheirDiscsAndLetBloodThrough) {
  for (const std::string mesh : {"M0", "M1", "M2", "M3"}) {
    const Mesh fluid = make_fluid(shape("ideal_left_ventricle", mesh));
    EXPECT_NEAR(area(fluid, "mitral") / (pi * 11e-3 * 11e-3), 1, 0.1) << mesh;
    EXPECT_NEAR(area(fluid, "aortic") / (pi * 10e-3 * 10e-3), 1, 0.15) << mesh;
    EXPECT_GT(free_area(fluid, "mitral"), 0.5 * area(fluid, "mitral")) << mesh;
    EXPECT_GT(free_area(fluid, "aortic"), 0.5 * area(fluid, "aortic")) << mesh;
    RecordProperty("free_mitral_mm2_" + mesh, int(1e6 * free_area(fluid, "mitral")));
    RecordProperty("free_aortic_mm2_" + mesh, int(1e6 * free_area(fluid, "aortic")));
  }
  const Mesh coarsest = make_fluid(shape("ideal_left_ventricle", "MXS"));
  EXPECT_GT(free_area(coarsest, "mitral"), 0);
  EXPECT_GT(free_area(coarsest, "aortic"), 0);
}

TEST(Piston, ColumnAndFluidMeetAtTheInterface) {
  const Mesh solid = make_solid(shape("piston")), fluid = make_fluid(shape("piston"));
  EXPECT_NO_THROW(check(solid));
  EXPECT_NO_THROW(check(fluid));
  EXPECT_EQ(points_on(solid, "interface"), points_on(fluid, "interface"));
  EXPECT_EQ(points_on(solid, "interface").size(), 9u);
  EXPECT_EQ(labels_in_use(solid), (std::set<std::string>{"interface", "x_low", "x_high", "y_low", "y_high", "z_low"}));
  EXPECT_EQ(labels_in_use(fluid), (std::set<std::string>{"interface", "x_low", "x_high", "y_low", "y_high", "z_high"}));
  EXPECT_NEAR(volume(fluid), 1e-6, 1e-18);
}

TEST(Slab, HasTheWantedCellsAndNoFluid) {
  const Mesh slab = make_solid(shape("slab"));
  EXPECT_NO_THROW(check(slab));
  EXPECT_EQ(slab.n_cells(), 40u * 14u * 6u);
  EXPECT_NEAR(volume(slab), 420e-9, 1e-18);
  EXPECT_THROW(make_fluid(shape("slab")), Failure);
}

TEST(Tube, IsValidAndConformsAtTheWall) {
  const Mesh solid = make_solid(shape("tube")), fluid = make_fluid(shape("tube"));
  EXPECT_NO_THROW(check(solid));
  EXPECT_NO_THROW(check(fluid));
  EXPECT_EQ(points_on(solid, "interface"), points_on(fluid, "interface"));
  EXPECT_EQ(labels_in_use(solid), (std::set<std::string>{"interface", "outer", "ends"}));
  EXPECT_EQ(labels_in_use(fluid), (std::set<std::string>{"interface", "inlet", "outlet"}));
  EXPECT_NEAR(volume(fluid) / (pi * 25e-6 * 50e-3), 1, 0.03); // a polygon of 16 sides
  EXPECT_NEAR(area(fluid, "inlet"), volume(fluid) / 50e-3, 1e-12);
}

TEST(GeometryParameters, RefuseOverlappingValvesAndParallelFibresAndSheets) {
  const auto complaint = [](const std::string &scene) -> std::string {
    try {
      read_scene(scene, "test.yaml");
      return "";
    } catch (const Failure &failure) {
      return failure.what();
    }
  };
  EXPECT_NE(complaint("geometry: {ventricle: {mitral_centre: 0 mm}}").find("overlap"), std::string::npos);
  EXPECT_NE(complaint("fibres: {rule: constant, sheet: [2, 0, 0]}").find("parallel"), std::string::npos);
  EXPECT_NE(complaint("geometry: {slab: {size: [20 mm, 0 mm, 3 mm]}}").find("positive"), std::string::npos);
}

TEST(Tetrahedra, FillTheSameVolumeWithTheSameBoundaryOnTheSameVertices) {
  const Mesh hexahedra = make_box({0, 0, 0}, {1, 2, 3}, {2, 3, 2}), tetrahedra = make_tetrahedra(hexahedra);
  EXPECT_NO_THROW(check(tetrahedra));
  EXPECT_EQ(tetrahedra.n_cells(), 5 * hexahedra.n_cells());
  EXPECT_EQ(tetrahedra.points, hexahedra.points);
  EXPECT_NEAR(volume(tetrahedra), 6, 1e-12);
  for (const auto &label : hexahedra.labels)
    EXPECT_NEAR(area(tetrahedra, label), area(hexahedra, label), 1e-12) << label;
}

namespace {

using Triangle = std::set<Point3>;

std::set<Triangle> triangles_on(const Mesh &mesh, const std::string &label) {
  std::set<Triangle> triangles;
  for (const auto &face : mesh.faces)
    if (mesh.labels[face.label] == label)
      triangles.insert({mesh.points[face.vertices[0]], mesh.points[face.vertices[1]], mesh.points[face.vertices[2]]});
  return triangles;
}

} // namespace

TEST(Tetrahedra, OfWallAndBloodShareTheTrianglesOfTheInterface) {
  for (const auto &[name, mesh] :
       {std::pair("ideal_left_ventricle", "MXS"), std::pair("ideal_left_ventricle", "M0"),
        std::pair("ideal_left_ventricle", "M1"), std::pair("tube", ""), std::pair("piston", "")}) {
    Parameters parameters = shape(name, mesh);
    parameters.cells = "tetrahedra";
    const Mesh solid = make_solid(parameters), fluid = make_fluid(parameters);
    EXPECT_NO_THROW(check(solid)) << name << mesh;
    EXPECT_NO_THROW(check(fluid)) << name << mesh;
    EXPECT_FALSE(triangles_on(solid, "interface").empty());
    EXPECT_EQ(triangles_on(solid, "interface"), triangles_on(fluid, "interface")) << name << mesh;
  }
}

TEST(Tetrahedra, ARingOfThreeHexahedraIsRefused) {
  Mesh ring; // twelve vertices: three corners inside, three outside, below and above
  for (unsigned z = 0; z < 2; ++z)
    for (unsigned k = 0; k < 6; ++k)
      ring.points.push_back(
          {(1 + k / 3) * std::cos(2 * pi * k / 3), (1 + k / 3) * std::sin(2 * pi * k / 3), double(z)});
  for (unsigned c = 0; c < 3; ++c)
    for (unsigned v = 0; v < 8; ++v)
      ring.cells.push_back((v & 1 ? 3 : 0) + (c + (v >> 1 & 1)) % 3 + 6 * (v >> 2));
  EXPECT_THROW(make_tetrahedra(ring), Failure);
}

TEST(LongestEdge, IsThatOfACellNotOfItsDiagonals) {
  const Mesh box = make_box({0, 0, 0}, {2, 3, 8}, {2, 1, 2});
  EXPECT_DOUBLE_EQ(longest_edge(box), 4);
  EXPECT_DOUBLE_EQ(longest_edge(make_tetrahedra(box)), 5); // across the largest faces
}

/// Every mesh gets as many refinements as its edges need.
TEST(LongestEdge, DecidesHowOftenTissueIsRefined) {
  const std::pair<const char *, int> expected[] = {{"MXS", 3}, {"M0", 2}, {"M1", 1}, {"M2", 0}, {"M3", 0}};
  ep::Parameters automatic, fixed;
  fixed.automatic_refinements = false;
  fixed.refinements = 5;
  for (const auto &[mesh, refinements] : expected) {
    Parameters parameters;
    parameters.mesh = mesh;
    const double edge = longest_edge(make_solid(parameters));
    EXPECT_EQ(automatic.refinements_of(edge), refinements) << mesh;
    EXPECT_EQ(fixed.refinements_of(edge), 5);
  }
}

TEST(MeshCheck, NamesAnInvertedCell) {
  Mesh mesh = make_box({0, 0, 0}, {1, 1, 1}, {2, 1, 1});
  mesh.points[1][0] = 1.5; // beyond its neighbour
  try {
    check(mesh);
    FAIL() << "an inverted cell went unnoticed";
  } catch (const Failure &failure) {
    EXPECT_EQ(failure.code(), ExitCode::not_finite);
    EXPECT_NE(std::string(failure.what()).find("cell 1"), std::string::npos) << failure.what();
  }
}

TEST(MeshCheck, MissesNoUnlabelledFace) {
  Mesh mesh = make_box({0, 0, 0}, {1, 1, 1}, {1, 1, 1});
  mesh.faces.pop_back();
  EXPECT_THROW(check(mesh), Failure);
}
