#pragma once

#include "mech_solver/boundary_terms.h"

namespace heartbus::mech {

/// The cavity behind the interface, closed by a lid of straight lines from the rim to its centre, which has to be held.
class Cavity {
 public:
  explicit Cavity(const fem::LagrangeSpace &space);
  /// [m^3]. Collective.
  double volume(const fem::Vector &d) const;
  /// Owned nodes where another part of the boundary begins.
  const std::vector<unsigned> &rim() const { return rim_; }

 private:
  const fem::LagrangeSpace &space_;
  LoadedSurface surface_;
  std::vector<unsigned> rim_;
  double n_rim_ = 0; ///< of all ranks
};

} // namespace heartbus::mech
