#include "common/geometry/o_grid.h"

#include <algorithm>

namespace heartbus::geometry {
namespace {

/// sum of weight * point
Point3 combine(std::initializer_list<std::pair<double, Point3>> terms) {
  Point3 sum{};
  for (const auto &term : terms)
    for (unsigned c = 0; c < 3; ++c)
      sum[c] += term.first * term.second[c];
  return sum;
}

/// Hexahedra between consecutive copies of a quadrilateral; `node(column, layer)` numbers them outwards.
template <class NodeNumber>
void extrude(Mesh &mesh, const std::vector<std::array<unsigned, 4>> &quads, unsigned layers, const NodeNumber &node) {
  for (const auto &quad : quads)
    for (unsigned layer = 0; layer < layers; ++layer)
      for (unsigned l : {layer, layer + 1})
        for (unsigned column : quad)
          mesh.cells.push_back(node(column, l));
}

template <class Predicate>
bool all(const std::array<unsigned, 4> &vertices, const Predicate &predicate) {
  return std::all_of(vertices.begin(), vertices.end(), predicate);
}

} // namespace

OGrid::OGrid(unsigned n, unsigned m, bool closed) : n_(n), m_(m), closed_(closed) {
  column_of_.assign((n + 1) * (n + 1) * (m + 1), 0);
  for (unsigned k = 0; k <= m; ++k)
    for (unsigned j = 0; j <= n; ++j)
      for (unsigned i = 0; i <= n; ++i)
        if (on_surface({i, j, k})) {
          column_of_[lattice(i, j, k)] = surface_nodes_.size();
          surface_nodes_.push_back({i, j, k});
        }
  for (unsigned k = 0; k < m; ++k)
    for (unsigned a = 0; a < n; ++a) {
      add_quad({0, a, k}, 2, 1);
      add_quad({n, a, k}, 1, 2);
      add_quad({a, 0, k}, 0, 2);
      add_quad({a, n, k}, 2, 0);
    }
  for (unsigned j = 0; j < n && closed; ++j)
    for (unsigned i = 0; i < n; ++i)
      add_quad({i, j, 0}, 1, 0);
}

bool OGrid::on_surface(const Node &p) const {
  return p.i == 0 || p.i == n_ || p.j == 0 || p.j == n_ || (closed_ && p.k == 0);
}

void OGrid::add_quad(Node origin, unsigned first, unsigned second) {
  std::array<unsigned, 4> quad;
  for (unsigned v = 0; v < 4; ++v) {
    unsigned p[3] = {origin.i, origin.j, origin.k};
    p[first] += v & 1;
    p[second] += v >> 1;
    quad[v] = column_of_[lattice(p[0], p[1], p[2])];
  }
  surface_quads_.push_back(quad);
}

/// Transfinite interpolation: a Coons patch in every section k, corrected so that the closed end is met.
std::vector<Point3> OGrid::core_points(const CorePoint &core) const {
  const auto patch = [&](unsigned i, unsigned j, unsigned k) {
    const double x = double(i) / n_, y = double(j) / n_;
    return combine({{1 - x, core({0, j, k})},
                    {x, core({n_, j, k})},
                    {1 - y, core({i, 0, k})},
                    {y, core({i, n_, k})},
                    {-(1 - x) * (1 - y), core({0, 0, k})},
                    {-x * (1 - y), core({n_, 0, k})},
                    {-(1 - x) * y, core({0, n_, k})},
                    {-x * y, core({n_, n_, k})}});
  };
  std::vector<Point3> points;
  for (unsigned k = 0; k <= m_; ++k)
    for (unsigned j = 0; j <= n_; ++j)
      for (unsigned i = 0; i <= n_; ++i) {
        const double to_end = 1 - double(k) / m_;
        if (on_surface({i, j, k}))
          points.push_back(core({i, j, k}));
        else if (closed_)
          points.push_back(combine({{1, patch(i, j, k)}, {to_end, core({i, j, 0})}, {-to_end, patch(i, j, 0)}}));
        else
          points.push_back(patch(i, j, k));
      }
  return points;
}

Mesh OGrid::cavity(unsigned shells, const CorePoint &core, const WallPoint &wall,
                   const std::vector<std::string> &end_labels,
                   const std::function<unsigned(const Point3 &)> &label_end) const {
  Mesh mesh;
  mesh.points = core_points(core);
  const unsigned n_core = mesh.points.size(), n_columns = surface_nodes_.size();
  for (unsigned shell = 1; shell <= shells; ++shell)
    for (const Node &node : surface_nodes_) {
      const double t = double(shell) / shells;
      const Point3 outer = wall(node, 0); // taken as it is on the interface: both meshes hold the same bits
      mesh.points.push_back(shell == shells ? outer : combine({{1 - t, core(node)}, {t, outer}}));
    }
  for (unsigned k = 0; k < m_; ++k)
    for (unsigned j = 0; j < n_; ++j)
      for (unsigned i = 0; i < n_; ++i)
        for (unsigned v = 0; v < 8; ++v)
          mesh.cells.push_back(lattice(i + (v & 1), j + (v >> 1 & 1), k + (v >> 2)));
  extrude(mesh, surface_quads_, shells, [&](unsigned column, unsigned layer) {
    const Node &p = surface_nodes_[column];
    return layer == 0 ? lattice(p.i, p.j, p.k) : n_core + (layer - 1) * n_columns + column;
  });
  mesh.materials.assign(mesh.n_cells(), 0);
  mesh.material_names = {"blood"};
  std::vector<std::string> labels{"interface"};
  labels.insert(labels.end(), end_labels.begin(), end_labels.end());
  const unsigned first_outer = n_core + (shells - 1) * n_columns;
  label_boundary(mesh, labels, [&](const std::array<unsigned, 4> &face) {
    return all(face, [&](unsigned v) { return v >= first_outer; }) ? 0 : 1 + label_end(face_centre(mesh, face));
  });
  return mesh;
}

Mesh OGrid::wall(unsigned layers, const WallPoint &wall, const std::string &outside, const std::string &end) const {
  Mesh mesh;
  const unsigned n_columns = surface_nodes_.size();
  for (unsigned layer = 0; layer <= layers; ++layer)
    for (const Node &node : surface_nodes_)
      mesh.points.push_back(wall(node, double(layer) / layers));
  extrude(mesh, surface_quads_, layers, [&](unsigned column, unsigned layer) { return layer * n_columns + column; });
  mesh.materials.assign(mesh.n_cells(), 0);
  mesh.material_names = {"tissue"};
  label_boundary(mesh, {"interface", outside, end}, [&](const std::array<unsigned, 4> &face) {
    if (all(face, [&](unsigned v) { return v < n_columns; }))
      return 0u;
    return all(face, [&](unsigned v) { return v >= layers * n_columns; }) ? 1u : 2u;
  });
  return mesh;
}

} // namespace heartbus::geometry
