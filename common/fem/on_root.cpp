#include "common/fem/on_root.h"

#include <deal.II/base/mpi.h>

namespace heartbus::fem {

void on_root(MPI_Comm communicator, const std::function<void()> &action) {
  std::pair<int, std::string> failed{0, ""};
  if (dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
    try {
      action();
    } catch (const Failure &failure) {
      failed = {static_cast<int>(failure.code()), failure.what()};
    }
  failed = dealii::Utilities::MPI::broadcast(communicator, failed);
  if (failed.first != 0)
    throw Failure(static_cast<ExitCode>(failed.first), failed.second);
}

geometry::Mesh mesh_on_root(MPI_Comm communicator, const std::function<geometry::Mesh()> &make) {
  geometry::Mesh mesh;
  on_root(communicator, [&] { mesh = make(); });
  mesh.kind = static_cast<geometry::Mesh::CellKind>(
      dealii::Utilities::MPI::broadcast(communicator, static_cast<int>(mesh.kind)));
  mesh.labels = dealii::Utilities::MPI::broadcast(communicator, mesh.labels);
  mesh.material_names = dealii::Utilities::MPI::broadcast(communicator, mesh.material_names);
  return mesh;
}

} // namespace heartbus::fem
