#include "common/geometry/shapes.h"

#include "common/base/failure.h"
#include "common/geometry/mesh_file.h"
#include "common/geometry/o_grid.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace heartbus::geometry {
namespace {

constexpr double pi = 3.14159265358979323846;

/// Numbers of cells of the ideal left ventricle: core n x n x m, shells around it, layers through the wall. M1 to M3
/// have about as many cells as the meshes of the paper's Table 1 and refine each other in the ratio 2 : 3 : 4.
struct VentricleSize {
  unsigned n, m, shells, layers;
};
const std::map<std::string, VentricleSize> ventricle_sizes{{"MXS", {4, 2, 1, 2}},
                                                           {"M0", {6, 5, 2, 4}},
                                                           {"M1", {10, 37, 1, 4}},
                                                           {"M2", {15, 54, 1, 6}},
                                                           {"M3", {20, 74, 1, 8}}};

/// Places the nodes of an O-grid in the truncated ellipsoid. Seen from the centre of the base, the core's surface is a
/// box of unit half width whose depth makes the rows of cells from base to apex evenly spaced; its central projection
/// on the sphere gives azimuth and polar angle of a node, the latter stretched to the ellipsoid's parametric angle.
class Ventricle {
 public:
  Ventricle(const VentricleParameters &parameters, const VentricleSize &size)
      : p_(parameters), size_(size), grid_(size.n, size.m, true) {}

  Mesh wall() const { return grid_.wall(size_.layers, wall_point(), "epicardium", "base"); }

  Mesh cavity() const {
    const auto inside = [](const Point3 &x, double centre, double radius) {
      return std::hypot(x[0] - centre, x[1]) <= radius;
    };
    return grid_.cavity(
        size_.shells, [this](const OGrid::Node &node) { return core(node); }, wall_point(),
        {"base", "mitral", "aortic"},
        [&](const Point3 &x) {
          return inside(x, p_.mitral_centre, p_.mitral_radius)   ? 1u
                 : inside(x, p_.aortic_centre, p_.aortic_radius) ? 2u
                                                                 : 0u;
        });
  }

 private:
  OGrid::WallPoint wall_point() const {
    return [this](const OGrid::Node &node, double s) { return point(node, s); };
  }

  /// Even angles around the axis at the base, even squares at the apex.
  double across(unsigned i, double height) const {
    const double x = 2. * i / size_.n - 1;
    return height * std::tan(pi / 4 * x) + (1 - height) * x;
  }

  Point3 point(const OGrid::Node &node, double s) const {
    const double height = double(node.k) / size_.m;
    const double x = across(node.i, height), y = across(node.j, height), r = std::hypot(x, y);
    const double steepest = pi / 2 * size_.m / (size_.m + 0.5 * size_.n);
    const double polar = std::atan2(r, std::tan(steepest * (1 - height))) / (pi / 2); // 0 at the apex, 1 at the base
    const double a = p_.endocardium_across + s * p_.wall, c = p_.endocardium_along + s * p_.wall;
    // Cells would be small at the apex, where the ellipse is short for its angle: open it.
    const double angle = std::acos(-p_.base_height / c) * polar * (1 + 0.4 * (1 - polar));
    const double radius = a * std::sin(angle);
    return {r > 0 ? radius * x / r : 0, r > 0 ? radius * y / r : 0,
            node.k == size_.m ? p_.base_height : -c * std::cos(angle)};
  }

  /// The interface, shrunk towards the centre of the base so that cells stay evenly sized.
  Point3 shrunk(const OGrid::Node &node) const {
    const double n = size_.n, m = size_.m, shells = size_.shells;
    const Point3 x = point(node, 0);
    const double across = n / (n + 2 * shells), along = m / (m + shells);
    return {across * x[0], across * x[1], p_.base_height + along * (x[2] - p_.base_height)};
  }

  /// The core's surface lies between the shrunk interface and the box through its four edges: on a smooth surface the
  /// three edges that meet in a corner of the core would lie in one plane.
  Point3 core(const OGrid::Node &node) const {
    constexpr double boxiness = 0.5;
    const Point3 smooth = shrunk(node), corner = shrunk({size_.n, size_.n, node.k});
    const Point3 box{corner[0] * (2. * node.i / size_.n - 1), corner[1] * (2. * node.j / size_.n - 1), corner[2]};
    Point3 x;
    for (unsigned c = 0; c < 3; ++c)
      x[c] = (1 - boxiness) * smooth[c] + boxiness * box[c];
    return x;
  }

  VentricleParameters p_;
  VentricleSize size_;
  OGrid grid_;
};

/// A circular tube along z from 0, its core a rounded square.
class Tube {
 public:
  explicit Tube(const TubeParameters &parameters)
      : p_(parameters), grid_(parameters.cells_across, parameters.cells_along, false) {}

  Mesh wall() const { return grid_.wall(p_.layers, wall_point(), "outer", "ends"); }

  Mesh cavity() const {
    return grid_.cavity(
        p_.shells, [this](const OGrid::Node &node) { return core(node); }, wall_point(), {"inlet", "outlet"},
        [&](const Point3 &x) { return x[2] < p_.length / 2 ? 0u : 1u; });
  }

 private:
  OGrid::WallPoint wall_point() const {
    return [this](const OGrid::Node &node, double s) { return point(node, p_.radius + s * p_.wall); };
  }

  Point3 point(const OGrid::Node &node, double radius) const {
    const double x = std::tan(pi / 4 * (2. * node.i / p_.cells_across - 1)),
                 y = std::tan(pi / 4 * (2. * node.j / p_.cells_across - 1)), r = std::hypot(x, y);
    return {radius * x / r, radius * y / r, p_.length * node.k / p_.cells_along};
  }

  Point3 core(const OGrid::Node &node) const {
    const Point3 x = point(node, 1);
    const double square = 1 / (std::sqrt(2.) * std::max(std::abs(x[0]), std::abs(x[1])));
    return point(node, p_.radius * p_.cells_across / (p_.cells_across + 2. * p_.shells) * (0.3 + 0.7 * square));
  }

  TubeParameters p_;
  OGrid grid_;
};

Mesh make_piston_part(const PistonParameters &p, double z_low, double z_high, int cells, const std::string &interface) {
  const unsigned across = p.cells_across;
  Mesh mesh = make_box({0, 0, z_low}, {p.width, p.width, z_high}, {across, across, unsigned(cells)});
  std::replace(mesh.labels.begin(), mesh.labels.end(), interface, std::string("interface"));
  return mesh;
}

/// Its far end stays; the near one is moved to the cylinder, whose foremost line is at x = 0.
void hollow_out(Mesh &mesh, const SlabParameters &p) {
  for (Point3 &x : mesh.points) {
    const double y = x[1] - p.size[1] / 2, depth = p.hollow - std::sqrt(p.hollow * p.hollow - y * y);
    x[0] -= depth * (1 - x[0] / p.size[0]);
  }
}

Mesh make_slab(const SlabParameters &p) {
  std::array<unsigned, 3> n;
  for (unsigned c = 0; c < 3; ++c)
    n[c] = p.cells.empty() ? std::max(1L, std::lround(p.size[c] / p.cell)) : std::lround(p.cells[c]);
  Mesh mesh = make_box({0, 0, 0}, {p.size[0], p.size[1], p.size[2]}, n);
  if (p.hollow > 0)
    hollow_out(mesh, p);
  return mesh;
}

Ventricle make_ventricle(const Parameters &p) {
  const VentricleParameters &v = p.ventricle;
  const VentricleSize custom{unsigned(v.cells_across), unsigned(v.cells_along), unsigned(v.shells), unsigned(v.layers)};
  return {v, p.mesh == "custom" ? custom : ventricle_sizes.at(p.mesh)};
}

using Labels = std::vector<std::string>;

/// Of a file without this part: nothing.
MeshSummary summary_of_file(const Parameters &p, const std::string &part) {
  const MeshFile file(p.mesh);
  return file.has(part) ? file.summary(part) : MeshSummary();
}

Mesh make_hexahedral_solid(const Parameters &p) {
  if (p.shape == "piston")
    return make_piston_part(p.piston, -p.piston.column, 0, p.piston.cells_column, "z_high");
  if (p.shape == "slab")
    return make_slab(p.slab);
  return p.shape == "tube" ? Tube(p.tube).wall() : make_ventricle(p).wall();
}

Mesh make_hexahedral_fluid(const Parameters &p) {
  if (p.shape == "slab")
    throw Failure(ExitCode::scene,
                  "geometry: the shape `slab` has no fluid; take ideal_left_ventricle, piston or tube");
  if (p.shape == "piston")
    return make_piston_part(p.piston, 0, p.piston.fluid, p.piston.cells_fluid, "z_low");
  return p.shape == "tube" ? Tube(p.tube).cavity() : make_ventricle(p).cavity();
}

Mesh in_wanted_cells(const Parameters &p, const Mesh &hexahedra) {
  return p.cells == "tetrahedra" ? make_tetrahedra(hexahedra) : hexahedra;
}

} // namespace

std::vector<std::string> solid_labels(const Parameters &p) {
  if (p.shape == "file")
    return summary_of_file(p, "solid").labels;
  if (p.shape == "piston")
    return {"x_low", "x_high", "y_low", "y_high", "z_low", "interface"};
  if (p.shape == "slab")
    return {"x_low", "x_high", "y_low", "y_high", "z_low", "z_high"};
  return p.shape == "tube" ? Labels{"interface", "outer", "ends"} : Labels{"interface", "epicardium", "base"};
}

std::vector<std::string> fluid_labels(const Parameters &p) {
  if (p.shape == "file")
    return summary_of_file(p, "fluid").labels;
  if (p.shape == "slab")
    return {};
  if (p.shape == "piston")
    return {"x_low", "x_high", "y_low", "y_high", "interface", "z_high"};
  return p.shape == "tube" ? Labels{"interface", "inlet", "outlet"} : Labels{"interface", "base", "mitral", "aortic"};
}

std::vector<std::string> solid_regions(const Parameters &p) {
  return p.shape == "file" ? summary_of_file(p, "solid").regions : make_solid(p).material_names;
}

bool brings_fibres(const Parameters &p) { return p.shape == "file" && summary_of_file(p, "solid").has_fibres; }

std::size_t n_solid_points(const Parameters &p) {
  return p.shape == "file" ? summary_of_file(p, "solid").n_points : make_solid(p).points.size();
}

std::size_t n_fluid_points(const Parameters &p) {
  if (p.shape == "slab")
    return 0;
  return p.shape == "file" ? summary_of_file(p, "fluid").n_points : make_fluid(p).points.size();
}

std::string checksum_of_meshes(const Parameters &p) { return MeshFile(p.mesh).checksum(); }

Mesh make_solid(const Parameters &p) {
  return p.shape == "file" ? MeshFile(p.mesh).read("solid") : in_wanted_cells(p, make_hexahedral_solid(p));
}

Mesh make_fluid(const Parameters &p) {
  return p.shape == "file" ? MeshFile(p.mesh).read("fluid") : in_wanted_cells(p, make_hexahedral_fluid(p));
}

} // namespace heartbus::geometry
