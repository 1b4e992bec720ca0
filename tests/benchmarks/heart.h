#pragma once

#include "common/fibres/fibres.h"
#include "common/geometry/shapes.h"
#include "scene/scene.h"

#include <mpi.h>
#include <string>

/// The ideal ventricle on mesh M1, on which the benchmarks run.
namespace heartbus::benchmarks {

inline constexpr double dt = 2e-4; ///< [s]

inline const SceneParameters &scene() {
  static const SceneParameters parameters = [] {
    SceneParameters s;
    s.geometry.mesh = "M1";
    return s;
  }();
  return parameters;
}

struct Wall {
  explicit Wall(unsigned refinements = 0)
      : space(MPI_COMM_WORLD, geometry::make_solid(scene().geometry), refinements), fibres(space, scene().fibres) {}
  fem::LagrangeSpace space;
  fem::Fibres fibres;
};

/// A smooth motion of the ventricle that inverts nothing: 5 % wider, 3 % shorter.
inline fem::Vector smooth_displacement(const fem::LagrangeSpace &space) {
  fem::Vector d = space.make_vector(3);
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
    for (unsigned i = 0; i < 3; ++i)
      d.local_element(3 * node + i) = (i < 2 ? 0.05 : -0.03) * space.points()[node][i];
  d.update_ghost_values();
  return d;
}

} // namespace heartbus::benchmarks
