#pragma once

#include <array>
#include <string>
#include <vector>

namespace heartbus::geometry {

using Point3 = std::array<double, 3>;

/// A whole mesh, held by one rank before it is distributed: straight-sided cells of one kind, labelled
/// boundary faces. It knows nothing of deal.II, so readers and generators of meshes need not either.
struct Mesh {
  enum class CellKind { hexahedron, tetrahedron };

  /// Unit vectors along fibre and sheet, orthogonal.
  using Fibre = std::array<Point3, 2>;

  struct Face {
    std::array<unsigned, 4> vertices; ///< quadrilateral in lexicographic order, or a triangle with vertices[3] unused
    unsigned label;                   ///< index into `labels`
  };

  CellKind kind = CellKind::hexahedron;
  std::vector<Point3> points;      ///< vertex coordinates [m], reference configuration
  std::vector<unsigned> cells;     ///< vertices_per_cell() indices a cell; hexahedra in lexicographic order (x fastest)
  std::vector<unsigned> materials; ///< one a cell, index into `material_names`
  std::vector<Fibre> fibres;       ///< one a cell, of a solid that brings them along; else none
  std::vector<Face> faces;         ///< every boundary face, each once
  std::vector<std::string> labels; ///< names of the boundary parts, e.g. "interface", "base", "epicardium"
  std::vector<std::string> material_names;

  unsigned vertices_per_cell() const { return kind == CellKind::hexahedron ? 8 : 4; }
  unsigned vertices_per_face() const { return kind == CellKind::hexahedron ? 4 : 3; }
  std::size_t n_cells() const { return cells.size() / vertices_per_cell(); }
};

} // namespace heartbus::geometry
