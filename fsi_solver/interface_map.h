#pragma once

#include "common/fem/lagrange_space.h"

#include <vector>

namespace heartbus::fsi {

/// Pairs the nodes of the label `interface` of two conforming meshes on one communicator and carries values between
/// their owners, which differ: each mesh is cut for itself. Values are ordered as the owned nodes of a side.
class InterfaceMap {
 public:
  /// Collective. Throws Failure(map) when a node has no partner.
  InterfaceMap(const fem::LagrangeSpace &fluid, const fem::LagrangeSpace &solid);

  const std::vector<unsigned> &fluid_nodes() const { return fluid_.nodes; } ///< local numbers of owned nodes
  const std::vector<unsigned> &solid_nodes() const { return solid_.nodes; }

  /// `components` values a node; collective.
  std::vector<double> to_fluid(const std::vector<double> &values, unsigned components) const;
  std::vector<double> to_solid(const std::vector<double> &values, unsigned components) const;

 private:
  struct Side {
    std::vector<unsigned> nodes;
    std::vector<int> order;  ///< positions in `nodes`, in the order of the messages
    std::vector<int> counts; ///< nodes by rank of the other side
  };
  std::vector<double> carry(const Side &from, const Side &to, const std::vector<double> &values,
                            unsigned components) const;
  MPI_Comm communicator_;
  Side fluid_, solid_;
};

} // namespace heartbus::fsi
