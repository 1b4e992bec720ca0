#include "common/fem/output_mesh.h"

namespace heartbus::fem {

io::OutputMesh output_mesh(const LagrangeSpace &space) {
  io::OutputMesh mesh;
  mesh.first_owned_node = space.first_owned_node();
  mesh.points.assign(space.points().begin(), space.points().begin() + space.n_owned_nodes());
  mesh.nodes_per_cell = space.nodes_per_cell();
  for (unsigned slot = 0; slot < space.n_slots(); ++slot)
    if (space.slot_owned(slot))
      for (unsigned a = 0; a < space.nodes_per_cell(); ++a)
        mesh.cells.push_back(space.global_node(space.cell_nodes(slot)[a]));
  return mesh;
}

} // namespace heartbus::fem
