#pragma once

#include "common/geometry/mesh.h"

#include <map>
#include <string>

namespace heartbus::geometry {

/// Writes meshes as a mesh file (docs/meshes.md), for programs that bring no generator of their own: by name of part,
/// "solid" and "fluid". The file appears when it is complete. Failure(file).
void write_mesh_file(const std::string &name, const std::map<std::string, Mesh> &parts);

} // namespace heartbus::geometry
