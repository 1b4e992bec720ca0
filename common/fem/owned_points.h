#pragma once

#include "common/fem/lagrange_space.h"

namespace heartbus::fem {

/// Coordinates of owned nodes as the bus and states want them, three a point [m].
inline std::vector<double> owned_points(const LagrangeSpace &space, const std::vector<unsigned> &nodes) {
  std::vector<double> coordinates;
  for (const unsigned node : nodes)
    coordinates.insert(coordinates.end(), space.points()[node].begin(), space.points()[node].end());
  return coordinates;
}

/// Those of all owned nodes.
inline std::vector<double> owned_points(const LagrangeSpace &space) {
  std::vector<double> coordinates;
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
    coordinates.insert(coordinates.end(), space.points()[node].begin(), space.points()[node].end());
  return coordinates;
}

} // namespace heartbus::fem
