#pragma once

#include "fsi_solver/interface_map.h"

namespace heartbus::fsi {

/// The unknowns of blood and wall in one vector: on each rank [u, v, w, p of its fluid nodes | displacement of its
/// solid nodes]. The wall's entries on the interface are always zero: what moves there is the blood's velocity.
class MergedSpace {
 public:
  MergedSpace(const fem::LagrangeSpace &fluid, const fem::LagrangeSpace &solid);

  fem::Vector make_vector() const { return fem::Vector(partitioner_); }
  void split(const fem::Vector &x, fem::Vector &fluid, fem::Vector &solid) const;
  void merge(const fem::Vector &fluid, const fem::Vector &solid, fem::Vector &x) const;

  /// solid = factor * fluid on the interface.
  void move_wall(const fem::Vector &fluid, double factor, fem::Vector &solid) const;
  /// fluid += solid on the interface: from rows of the wall to rows of the blood.
  void add_force(const fem::Vector &solid, fem::Vector &fluid) const;
  /// solid = 0 on the interface.
  void clear_wall(fem::Vector &solid) const;

  const fem::LagrangeSpace &fluid() const { return fluid_; }
  const fem::LagrangeSpace &solid() const { return solid_; }
  const InterfaceMap &interface() const { return map_; }

 private:
  const fem::LagrangeSpace &fluid_, &solid_;
  InterfaceMap map_;
  std::shared_ptr<const dealii::Utilities::MPI::Partitioner> partitioner_;
};

} // namespace heartbus::fsi
