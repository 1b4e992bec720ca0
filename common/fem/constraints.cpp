#include "common/fem/constraints.h"

#include "common/base/failure.h"

#include <cmath>
#include <limits>
#include <sstream>

namespace heartbus::fem {
namespace {

/// The axis along which all normals of the label point.
unsigned flat_normal_axis(const LagrangeSpace &space, const std::string &label) {
  const BoundaryFaces faces = space.faces(label);
  std::array<double, 3> largest{};
  for (std::size_t k = 0; k < faces.normals.size(); ++k)
    largest[k % 3] = std::max(largest[k % 3], std::abs(faces.normals[k]));
  std::vector<unsigned> axes;
  for (unsigned i = 0; i < 3; ++i)
    if (dealii::Utilities::MPI::max(largest[i], space.communicator()) > 1e-6)
      axes.push_back(i);
  if (axes.size() != 1)
    throw Failure(ExitCode::scene, "the boundary '" + label +
                                       "' cannot be a slip wall: only flat faces normal to a coordinate axis can");
  return axes[0];
}

} // namespace

void fix_vector(const LagrangeSpace &space, unsigned components, const std::string &label, Constraints &constrained) {
  const auto on = space.nodes_on(label);
  for (unsigned node = 0; node < on.size(); ++node)
    for (unsigned i = 0; i < 3; ++i)
      constrained[node * components + i] |= on[node];
}

void fix_normal(const LagrangeSpace &space, unsigned components, const std::string &label, Constraints &constrained) {
  const auto on = space.nodes_on(label);
  const unsigned axis = flat_normal_axis(space, label);
  for (unsigned node = 0; node < on.size(); ++node)
    constrained[node * components + axis] |= on[node];
}

void zero_constrained(Vector &v, const Constraints &constrained) {
  if (!constrained.empty())
    for (unsigned i = 0; i < v.locally_owned_size(); ++i)
      if (constrained[i])
        v.local_element(i) = 0;
}

void refuse_inverted_cells(const LagrangeSpace &space, double smallest_J, unsigned slot, const std::string &what) {
  const MPI_Comm communicator = space.communicator();
  const double here = std::isfinite(smallest_J) ? smallest_J : -std::numeric_limits<double>::max();
  const double worst = dealii::Utilities::MPI::min(here, communicator);
  if (worst > 0)
    return;
  const unsigned rank = dealii::Utilities::MPI::this_mpi_process(communicator);
  const unsigned owner = dealii::Utilities::MPI::min(here == worst ? rank : ~0u, communicator);
  geometry::Point3 centre{};
  for (unsigned a = 0; rank == owner && a < space.nodes_per_cell(); ++a)
    for (unsigned i = 0; i < 3; ++i)
      centre[i] += space.points()[space.cell_nodes(slot)[a]][i] / space.nodes_per_cell();
  MPI_Bcast(centre.data(), 3, MPI_DOUBLE, owner, communicator);
  std::ostringstream message;
  message.precision(4);
  message << what << " inverts the cell around (" << 1e3 * centre[0] << ", " << 1e3 * centre[1] << ", "
          << 1e3 * centre[2] << ") mm at rest: det F = " << worst
          << ", which must be positive. The wall has moved further than the mesh of the blood can follow: look at the "
             "loads of the wall, at lifting.slip (flat walls along which the mesh may slide), at time.step, or take "
             "another geometry.mesh";
  throw Failure(ExitCode::not_finite, message.str());
}

} // namespace heartbus::fem
