#pragma once

#include "common/fem/lagrange_space.h"
#include "common/simd/small_matrix.h"

#include <string>
#include <vector>

namespace heartbus::fem {

/// Nodal functions in the wall, ghosts included, whose gradients say where its sides, its rings and its apex are. All
/// are collective and solved so tightly that they do not depend on the partition.

/// The harmonic phi with phi = 0 on `interface` and 1 on `epicardium`.
Vector transmural_coordinate(const LagrangeSpace &space);

/// lap psi = 1, psi = 0 on the labels, d psi / dn = 0 elsewhere: negative, rises from the apex, where it is least, to
/// the rings by the shortest ways, as seen by what diffuses. (The harmonic function between a point and the rings, of
/// Bayer et al. 2012, has the same lines in a body of revolution; but a point of a body carries no boundary value, so
/// that it depends on the mesh.)
Vector rise_to_rings(const LagrangeSpace &space, const std::vector<std::string> &rings);

/// w - length^2 lap w = 0, w = 1 on the labels: falls as exp(-distance / length) from there.
Vector nearness(const LagrangeSpace &space, const std::vector<std::string> &labels, double length);

/// Gradient of a nodal function, where a frame is needed: at the quadrature points. In a cell that has none, as a
/// linear tetrahedron with all vertices on one side of the wall, the mean around its nodes.
class WallGradient {
 public:
  /// Collective. The function has ghost values.
  WallGradient(const LagrangeSpace &space, const Vector &function);
  Vec3<double> at(unsigned slot, unsigned q) const;

 private:
  Vec3<double> of_cell(unsigned slot, unsigned q) const;
  const LagrangeSpace &space_;
  Vector function_, around_nodes_;
};

/// The function at the point of the cell to which the frame of quadrature point q belongs: in linear tetrahedra the
/// centroid, else q itself.
double value_at_frame(const LagrangeSpace &space, const Vector &function, unsigned slot, unsigned q);

} // namespace heartbus::fem
