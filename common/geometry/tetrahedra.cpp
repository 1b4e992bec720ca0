#include "common/base/failure.h"
#include "common/geometry/mesh_tools.h"

#include <algorithm>

namespace heartbus::geometry {
namespace {

enum class Colour : char { none, even, odd };

Colour other(Colour colour) { return colour == Colour::even ? Colour::odd : Colour::even; }

std::vector<std::vector<unsigned>> edge_neighbours(const Mesh &hexahedra) {
  std::vector<std::vector<unsigned>> neighbours(hexahedra.points.size());
  for (std::size_t k = 0; k < hexahedra.cells.size(); ++k)
    for (const unsigned axis : {1u, 2u, 4u})
      neighbours[hexahedra.cells[k]].push_back(hexahedra.cells[k / 8 * 8 + (k % 8 ^ axis)]);
  return neighbours;
}

/// Where colouring starts: the first vertex by coordinates, of the interface where there is one, so that both of its
/// meshes start alike.
unsigned first_vertex(const Mesh &mesh) {
  const unsigned interface = std::find(mesh.labels.begin(), mesh.labels.end(), "interface") - mesh.labels.begin();
  std::vector<unsigned> candidates;
  for (const auto &face : mesh.faces)
    if (face.label == interface)
      candidates.insert(candidates.end(), face.vertices.begin(), face.vertices.end());
  if (candidates.empty())
    candidates = mesh.cells;
  return *std::min_element(candidates.begin(), candidates.end(),
                           [&](unsigned a, unsigned b) { return mesh.points[a] < mesh.points[b]; });
}

/// Two colours, such that every edge joins an even and an odd vertex.
std::vector<Colour> two_colours(const Mesh &hexahedra) {
  const auto neighbours = edge_neighbours(hexahedra);
  std::vector<Colour> colours(hexahedra.points.size(), Colour::none);
  std::vector<unsigned> front{first_vertex(hexahedra)};
  colours[front[0]] = Colour::even;
  while (!front.empty()) {
    const unsigned vertex = front.back();
    front.pop_back();
    for (const unsigned next : neighbours[vertex]) {
      if (colours[next] == colours[vertex])
        throw Failure(ExitCode::scene, "geometry.cells: a ring of an odd number of hexahedra cannot be split into five "
                                       "tetrahedra each; an even number around it can");
      if (colours[next] == Colour::none) {
        colours[next] = other(colours[vertex]);
        front.push_back(next);
      }
    }
  }
  return colours;
}

/// The tetrahedron between the even corners of a cell, and the four that it leaves, all right-handed.
void split_cell(const unsigned *v, bool first_is_even, std::vector<unsigned> &cells) {
  using Corners = std::array<unsigned, 4>;
  const Corners inner = first_is_even ? Corners{0, 5, 3, 6} : Corners{1, 2, 4, 7};
  const unsigned first_axis = first_is_even ? 2 : 1, second_axis = 3 - first_axis;
  for (const unsigned corner : inner)
    cells.push_back(v[corner]);
  for (unsigned corner = 0; corner < 8; ++corner)
    if (std::find(inner.begin(), inner.end(), corner) == inner.end())
      cells.insert(cells.end(), {v[corner], v[corner ^ first_axis], v[corner ^ second_axis], v[corner ^ 4]});
}

} // namespace

Mesh make_tetrahedra(const Mesh &hexahedra) {
  const std::vector<Colour> colours = two_colours(hexahedra);
  Mesh mesh;
  mesh.kind = Mesh::CellKind::tetrahedron;
  mesh.points = hexahedra.points;
  mesh.labels = hexahedra.labels;
  mesh.material_names = hexahedra.material_names;
  for (std::size_t cell = 0; cell < hexahedra.n_cells(); ++cell) {
    const unsigned *v = &hexahedra.cells[8 * cell];
    split_cell(v, colours[v[0]] == Colour::even, mesh.cells);
    mesh.materials.insert(mesh.materials.end(), 5, hexahedra.materials[cell]);
  }
  for (const auto &face : hexahedra.faces) {
    const auto &q = face.vertices;
    if (colours[q[0]] == Colour::even) {
      mesh.faces.push_back({{q[0], q[1], q[3], 0}, face.label});
      mesh.faces.push_back({{q[0], q[3], q[2], 0}, face.label});
    } else {
      mesh.faces.push_back({{q[0], q[1], q[2], 0}, face.label});
      mesh.faces.push_back({{q[1], q[3], q[2], 0}, face.label});
    }
  }
  return mesh;
}

} // namespace heartbus::geometry
