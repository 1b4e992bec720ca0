#include "common/geometry/mesh_tools.h"

#include "common/base/failure.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace heartbus::geometry {
namespace {

Point3 operator-(const Point3 &a, const Point3 &b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

Point3 cross(const Point3 &a, const Point3 &b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double dot(const Point3 &a, const Point3 &b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

using FaceKey = std::array<unsigned, 4>;

FaceKey sorted(FaceKey vertices) {
  std::sort(vertices.begin(), vertices.end());
  return vertices;
}

/// Determinant of the trilinear map's Jacobian at reference point t in [0,1]^3.
double jacobian(const Mesh &mesh, std::size_t cell, const Point3 &t) {
  std::array<Point3, 3> d{};
  for (unsigned v = 0; v < 8; ++v) {
    const Point3 &x = mesh.points[mesh.cells[8 * cell + v]];
    for (unsigned e = 0; e < 3; ++e) {
      double slope = 1;
      for (unsigned i = 0; i < 3; ++i) {
        const bool high = v >> i & 1;
        slope *= i == e ? (high ? 1 : -1) : (high ? t[i] : 1 - t[i]);
      }
      for (unsigned c = 0; c < 3; ++c)
        d[e][c] += slope * x[c];
    }
  }
  return dot(cross(d[0], d[1]), d[2]);
}

double tetrahedron_volume(const Mesh &mesh, std::size_t cell) {
  const unsigned *v = &mesh.cells[4 * cell];
  const Point3 &o = mesh.points[v[0]];
  return dot(cross(mesh.points[v[1]] - o, mesh.points[v[2]] - o), mesh.points[v[3]] - o) / 6;
}

constexpr double gauss[2] = {0.21132486540518713, 0.78867513459481287};

/// Two Gauss points a direction integrate the determinant, quadratic in each coordinate, exactly.
double hexahedron_volume(const Mesh &mesh, std::size_t cell) {
  double sum = 0;
  for (unsigned q = 0; q < 8; ++q)
    sum += jacobian(mesh, cell, {gauss[q & 1], gauss[q >> 1 & 1], gauss[q >> 2]}) / 8;
  return sum;
}

/// Integrals of the vertices' shape functions over a face.
std::array<double, 4> vertex_areas(const Mesh &mesh, const Mesh::Face &face) {
  const auto x = [&](unsigned v) -> const Point3 & { return mesh.points[face.vertices[v]]; };
  if (mesh.kind == Mesh::CellKind::tetrahedron) {
    const Point3 n = cross(x(1) - x(0), x(2) - x(0));
    const double third = std::sqrt(dot(n, n)) / 6;
    return {third, third, third, 0};
  }
  std::array<double, 4> areas{};
  for (double s : gauss)
    for (double t : gauss) {
      Point3 ds, dt;
      for (unsigned c = 0; c < 3; ++c) {
        ds[c] = (1 - t) * (x(1)[c] - x(0)[c]) + t * (x(3)[c] - x(2)[c]);
        dt[c] = (1 - s) * (x(2)[c] - x(0)[c]) + s * (x(3)[c] - x(1)[c]);
      }
      const Point3 n = cross(ds, dt);
      const double weight = std::sqrt(dot(n, n)) / 4;
      const double shapes[4] = {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t};
      for (unsigned v = 0; v < 4; ++v)
        areas[v] += weight * shapes[v];
    }
  return areas;
}

std::string describe_cell(const Mesh &mesh, std::size_t cell) {
  Point3 centre{};
  const unsigned n = mesh.vertices_per_cell();
  for (unsigned v = 0; v < n; ++v)
    for (unsigned c = 0; c < 3; ++c)
      centre[c] += mesh.points[mesh.cells[n * cell + v]][c] / n;
  return "cell " + std::to_string(cell) + " around (" + std::to_string(centre[0]) + ", " + std::to_string(centre[1]) +
         ", " + std::to_string(centre[2]) + ") m";
}

struct FaceUse {
  FaceKey vertices; ///< in the cell's order
  std::size_t cell;
  unsigned count;
};

std::map<FaceKey, FaceUse> collect_faces(const Mesh &mesh) {
  std::map<FaceKey, FaceUse> uses;
  const auto faces = cell_faces(mesh.kind);
  const unsigned n = mesh.vertices_per_cell();
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell)
    for (const auto &face : faces) {
      FaceKey vertices{};
      for (unsigned v = 0; v < face.size(); ++v)
        vertices[v] = mesh.cells[n * cell + face[v]];
      ++uses.emplace(sorted(vertices), FaceUse{vertices, cell, 0}).first->second.count;
    }
  return uses;
}

unsigned label_index(const Mesh &mesh, const std::string &label) {
  return std::find(mesh.labels.begin(), mesh.labels.end(), label) - mesh.labels.begin();
}

} // namespace

std::vector<std::vector<unsigned>> cell_faces(Mesh::CellKind kind) {
  if (kind == Mesh::CellKind::tetrahedron)
    return {{0, 1, 2}, {1, 0, 3}, {0, 2, 3}, {2, 1, 3}};
  return {{0, 2, 4, 6}, {1, 3, 5, 7}, {0, 1, 4, 5}, {2, 3, 6, 7}, {0, 1, 2, 3}, {4, 5, 6, 7}};
}

void label_boundary(Mesh &mesh, const std::vector<std::string> &labels,
                    const std::function<unsigned(const std::array<unsigned, 4> &)> &classify) {
  mesh.labels = labels;
  mesh.faces.clear();
  for (const auto &entry : collect_faces(mesh))
    if (entry.second.count == 1)
      mesh.faces.push_back({entry.second.vertices, classify(entry.second.vertices)});
}

Mesh make_box(const Point3 &lower, const Point3 &upper, const std::array<unsigned, 3> &n) {
  Mesh mesh;
  for (unsigned k = 0; k <= n[2]; ++k)
    for (unsigned j = 0; j <= n[1]; ++j)
      for (unsigned i = 0; i <= n[0]; ++i) {
        const unsigned index[3] = {i, j, k};
        Point3 x;
        for (unsigned c = 0; c < 3; ++c) // exact at both ends, so that adjacent boxes share coordinates bit by bit
          x[c] = index[c] == n[c] ? upper[c] : lower[c] + index[c] * (upper[c] - lower[c]) / n[c];
        mesh.points.push_back(x);
      }
  const auto node = [&](unsigned i, unsigned j, unsigned k) { return i + (n[0] + 1) * (j + (n[1] + 1) * k); };
  for (unsigned k = 0; k < n[2]; ++k)
    for (unsigned j = 0; j < n[1]; ++j)
      for (unsigned i = 0; i < n[0]; ++i)
        for (unsigned v = 0; v < 8; ++v)
          mesh.cells.push_back(node(i + (v & 1), j + (v >> 1 & 1), k + (v >> 2)));
  mesh.materials.assign(mesh.n_cells(), 0);
  mesh.material_names = {"box"};
  label_boundary(mesh, {"x_low", "x_high", "y_low", "y_high", "z_low", "z_high"},
                 [&](const std::array<unsigned, 4> &vertices) {
                   for (unsigned c = 0; c < 3; ++c)
                     for (unsigned high = 0; high < 2; ++high)
                       if (std::all_of(vertices.begin(), vertices.end(),
                                       [&](unsigned v) { return mesh.points[v][c] == (high ? upper : lower)[c]; }))
                         return 2 * c + high;
                   throw Failure(ExitCode::scene, "make_box: the lower corner must lie below the upper corner");
                 });
  return mesh;
}

double volume(const Mesh &mesh) {
  const auto cell_volume = mesh.kind == Mesh::CellKind::hexahedron ? hexahedron_volume : tetrahedron_volume;
  double sum = 0;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell)
    sum += cell_volume(mesh, cell);
  return sum;
}

double area(const Mesh &mesh, const std::string &label) {
  const unsigned id = label_index(mesh, label);
  double sum = 0;
  for (const auto &face : mesh.faces)
    if (face.label == id)
      for (double a : vertex_areas(mesh, face))
        sum += a;
  return sum;
}

double free_area(const Mesh &mesh, const std::string &label) {
  const unsigned id = label_index(mesh, label), n = mesh.vertices_per_face();
  std::vector<bool> held(mesh.points.size(), false);
  for (const auto &face : mesh.faces)
    for (unsigned v = 0; v < n && face.label != id; ++v)
      held[face.vertices[v]] = true;
  double sum = 0;
  for (const auto &face : mesh.faces) {
    if (face.label != id)
      continue;
    const auto areas = vertex_areas(mesh, face);
    for (unsigned v = 0; v < n; ++v)
      sum += held[face.vertices[v]] ? 0 : areas[v];
  }
  return sum;
}

Point3 face_centre(const Mesh &mesh, const std::array<unsigned, 4> &vertices) {
  Point3 centre{};
  const unsigned n = mesh.vertices_per_face();
  for (unsigned v = 0; v < n; ++v)
    for (unsigned c = 0; c < 3; ++c)
      centre[c] += mesh.points[vertices[v]][c] / n;
  return centre;
}

double longest_edge(const Mesh &mesh) {
  double longest = 0;
  const unsigned n = mesh.vertices_per_cell();
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell)
    for (unsigned a = 0; a < n; ++a)
      for (unsigned b = a + 1; b < n; ++b) {
        const unsigned differ = a ^ b; // of a hexahedron, corners along one axis share an edge
        if (mesh.kind == Mesh::CellKind::hexahedron && (differ & (differ - 1)))
          continue;
        const Point3 edge = mesh.points[mesh.cells[n * cell + a]] - mesh.points[mesh.cells[n * cell + b]];
        longest = std::max(longest, std::sqrt(dot(edge, edge)));
      }
  return longest;
}

void check(const Mesh &mesh) {
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell)
    for (unsigned corner = 0; corner < mesh.vertices_per_cell(); ++corner) {
      const double j = mesh.kind == Mesh::CellKind::tetrahedron
                           ? tetrahedron_volume(mesh, cell)
                           : jacobian(mesh, cell, {corner & 1 ? 1. : 0., corner & 2 ? 1. : 0., corner & 4 ? 1. : 0.});
      if (!(j > 0))
        throw Failure(ExitCode::not_finite, "the mesh is inverted: " + describe_cell(mesh, cell) +
                                                " has the Jacobian " + std::to_string(j) + " at corner " +
                                                std::to_string(corner) + ", which must be positive");
    }
  auto uses = collect_faces(mesh);
  for (const auto &face : mesh.faces) {
    const auto use = uses.find(sorted(face.vertices));
    if (use == uses.end() || use->second.count != 1)
      throw Failure(ExitCode::scene, "a labelled face is no boundary face of the mesh, or is labelled twice");
    if (face.label >= mesh.labels.size())
      throw Failure(ExitCode::scene, "a boundary face carries a label without a name");
    use->second.count = 2;
  }
  for (const auto &use : uses)
    if (use.second.count != 2)
      throw Failure(ExitCode::scene, "a face of " + describe_cell(mesh, use.second.cell) +
                                         (use.second.count == 1 ? " lies on the boundary without a label"
                                                                : " belongs to more than two cells"));
}

} // namespace heartbus::geometry
