#pragma once

#include "common/geometry/mesh.h"

#include <array>
#include <functional>
#include <string>
#include <vector>

namespace heartbus::geometry {

/// Vertex indices, within a cell, of each of its faces.
std::vector<std::vector<unsigned>> cell_faces(Mesh::CellKind kind);

/// Fills `faces`: every face that belongs to one cell only is labelled labels[classify(vertices)].
void label_boundary(Mesh &mesh, const std::vector<std::string> &labels,
                    const std::function<unsigned(const std::array<unsigned, 4> &)> &classify);

/// Hexahedra filling a box; faces x_low, x_high, y_low, y_high, z_low, z_high, in this order.
Mesh make_box(const Point3 &lower, const Point3 &upper, const std::array<unsigned, 3> &n);

/// Splits every hexahedron into five tetrahedra on its own vertices; labels are kept. Diagonals of faces join
/// vertices of one colour of the chequerboard, so that neighbours conform, and so do two meshes that share the label
/// `interface`. Failure(scene) where the edges have no chequerboard, around rings of an odd number of cells.
Mesh make_tetrahedra(const Mesh &hexahedra);

/// Exact volume of the (trilinear) cells [m^3].
double volume(const Mesh &mesh);

/// Area of the faces of a label [m^2]; 0 when there is none.
double area(const Mesh &mesh, const std::string &label);

/// The part of an area that nodes carry which lie on this label only: what is left of an orifice when the nodes of its
/// rim, shared with a no-slip wall, do not move.
double free_area(const Mesh &mesh, const std::string &label);

/// Throws Failure when a cell is inverted at a corner, when a boundary face has no label, or when a labelled face does
/// not lie on the boundary.
void check(const Mesh &mesh);

/// Of all edges of all cells [m].
double longest_edge(const Mesh &mesh);

Point3 face_centre(const Mesh &mesh, const std::array<unsigned, 4> &vertices);

} // namespace heartbus::geometry
