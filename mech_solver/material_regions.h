#pragma once

#include "common/fem/lagrange_space.h"
#include "mech_solver/settings/parameters.h"

namespace heartbus::mech {

/// The cells of one material; a batch can hold cells of several, each then sees the others with weight zero.
struct MaterialRegion {
  Law law;
  double density; ///< [kg/m^3]
  bool contracts;
  std::vector<fem::VectorizedDouble> JxW; ///< [batch][q]
  std::vector<std::uint8_t> in_batch;     ///< [batch]
};

/// The muscle, which is all that the scene names no other material for, then those it names. Failure(scene) when the
/// mesh has no such region.
std::vector<MaterialRegion> material_regions(const fem::LagrangeSpace &space, const Parameters &parameters);

} // namespace heartbus::mech
