#include "mech_solver/cavity.h"

#include <deal.II/base/mpi.h>

namespace heartbus::mech {

Cavity::Cavity(const fem::LagrangeSpace &space) : space_(space), surface_(space, "interface") {
  const auto inside = space.nodes_on("interface");
  std::vector<bool> on_rim(space.n_owned_nodes());
  for (const std::string &label : space.labels())
    if (label != "interface") {
      const auto beside = space.nodes_on(label);
      for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
        on_rim[node] = on_rim[node] || (inside[node] && beside[node]);
    }
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
    if (on_rim[node])
      rim_.push_back(node);
  n_rim_ = dealii::Utilities::MPI::sum(double(rim_.size()), space.communicator());
}

/// V = -1/3 int (x - o) . n da over the moved interface, whose normals n point out of the wall, with the centre o of
/// the rim: the lid has no part in it.
double Cavity::volume(const fem::Vector &d) const {
  const auto place = [&](unsigned node, unsigned i) {
    return space_.points()[node][i] + d.local_element(3 * node + i);
  };
  fem::Vec3<double> centre{};
  for (unsigned i = 0; i < 3; ++i) {
    for (const unsigned node : rim_)
      centre[i] += place(node, i);
    centre[i] = n_rim_ > 0 ? dealii::Utilities::MPI::sum(centre[i], space_.communicator()) / n_rim_ : 0;
  }
  const fem::GhostValues ghosts(d);
  fem::Vector area = space_.make_vector(3);
  surface_.add_force(1, d, area);
  area.zero_out_ghost_values();
  double sum = 0;
  for (unsigned node = 0; node < space_.n_owned_nodes(); ++node)
    for (unsigned i = 0; i < 3; ++i)
      sum -= (place(node, i) - centre[i]) * area.local_element(3 * node + i);
  return dealii::Utilities::MPI::sum(sum, space_.communicator()) / 3;
}

} // namespace heartbus::mech
