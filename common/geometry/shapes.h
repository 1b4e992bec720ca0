#pragma once

#include "common/geometry/mesh.h"
#include "common/geometry/parameters.h"

namespace heartbus::geometry {

/// The labels of the two meshes, without making them; of the fluid none for shapes without fluid.
std::vector<std::string> solid_labels(const Parameters &parameters);
std::vector<std::string> fluid_labels(const Parameters &parameters);
/// The regions of the solid, by name.
std::vector<std::string> solid_regions(const Parameters &parameters);

/// Whether the mesh of the solid brings its fibres along.
bool brings_fibres(const Parameters &parameters);

/// Of the two meshes; a mesh file is not read for it. Of the fluid 0 for shapes without fluid.
std::size_t n_solid_points(const Parameters &parameters);
std::size_t n_fluid_points(const Parameters &parameters);
/// What tells the meshes of a file from others, whatever the file is called.
std::string checksum_of_meshes(const Parameters &parameters);

/// The mesh of the solid. Labels: ventricle `interface`, `epicardium`, `base`; tube `interface`, `outer`, `ends`;
/// piston `interface` (top), x_low, x_high, y_low, y_high, z_low; slab x_low .. z_high; file: what it says.
Mesh make_solid(const Parameters &parameters);

/// The mesh of the fluid at rest; on `interface` its nodes are those of the solid, bit by bit. Labels: ventricle
/// `interface`, `base`, `mitral`, `aortic`; tube `interface`, `inlet`, `outlet`; piston `interface` (bottom), x_low,
/// x_high, y_low, y_high, z_high; file: what it says. Failure(scene) for shapes without fluid.
Mesh make_fluid(const Parameters &parameters);

} // namespace heartbus::geometry
