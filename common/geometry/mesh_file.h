#pragma once

#include "common/geometry/mesh.h"

#include <cstdint>
#include <string>
#include <vector>

namespace heartbus::geometry {

/// How a mesh file says what it is, and its version.
inline constexpr const char *mesh_file_format = "heartbus mesh 1";

/// What a mesh file says of one of its two meshes, without reading it.
struct MeshSummary {
  Mesh::CellKind kind = Mesh::CellKind::tetrahedron;
  std::size_t n_points = 0, n_cells = 0;
  std::vector<std::string> labels, regions;
  bool has_fibres = false;
};

/// A mesh file as `tools/mesh import` writes it (docs/meshes.md): HDF5, a group `solid`, a group `fluid`, or both.
/// Everything is Failure(file) that names the file, or Failure(not_finite) for inverted cells.
class MeshFile {
 public:
  explicit MeshFile(const std::string &name);

  bool has(const std::string &part) const;
  MeshSummary summary(const std::string &part) const;
  /// Checked as `check` does, and that all numbers are finite, all indices within what they count, fibres orthonormal.
  Mesh read(const std::string &part) const;
  /// Of all bytes of the file, as text: whether two files hold the same mesh, whatever they are called.
  std::string checksum() const;

 private:
  std::string name_;
};

} // namespace heartbus::geometry
