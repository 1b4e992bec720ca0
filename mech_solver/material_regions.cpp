#include "mech_solver/material_regions.h"

#include "common/base/failure.h"
#include "common/units/nearest.h"

#include <algorithm>

namespace heartbus::mech {

using fem::n_lanes;

std::vector<MaterialRegion> material_regions(const fem::LagrangeSpace &space, const Parameters &parameters) {
  const auto &names = space.material_names();
  std::vector<unsigned> region_of(std::max<std::size_t>(names.size(), 1), 0);
  std::vector<MaterialRegion> regions{{parameters.chosen_law(), parameters.density, true, {}, {}}};
  for (const auto &[name, region] : parameters.regions) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end())
      throw Failure(ExitCode::scene, "mechanics.regions: the mesh has no region '" + name + "'" +
                                         config::did_you_mean(name, names) + " It has " + config::joined(names));
    region_of[found - names.begin()] = regions.size();
    regions.push_back({region.chosen_law(), region.density, region.contracts, {}, {}});
  }
  const unsigned n_q = space.n_q();
  for (MaterialRegion &region : regions) {
    region.JxW.assign(space.JxW(0), space.JxW(0) + std::size_t(space.n_batches()) * n_q);
    region.in_batch.assign(space.n_batches(), 0);
    for (unsigned slot = 0; slot < space.n_slots(); ++slot) {
      const bool here = space.slot_used(slot) && &regions[region_of[space.material(slot)]] == &region;
      region.in_batch[slot / n_lanes] |= here;
      for (unsigned q = 0; q < n_q && !here; ++q)
        region.JxW[(slot / n_lanes) * n_q + q][slot % n_lanes] = 0;
    }
  }
  return regions;
}

} // namespace heartbus::mech
