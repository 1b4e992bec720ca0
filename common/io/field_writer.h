#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mpi.h>
#include <string>
#include <vector>

namespace heartbus::io {

/// A distributed mesh as the writer sees it, deal.II-free: owned nodes with contiguous global numbers, owned cells.
struct OutputMesh {
  std::uint64_t first_owned_node = 0;
  std::vector<std::array<double, 3>> points; ///< [owned node], reference [m]
  unsigned nodes_per_cell = 8;               ///< 8: hexahedra (lexicographic), 4: tetrahedra, 10: quadratic tetrahedra
  std::vector<std::uint64_t> cells;          ///< owned cells, global node numbers
};

/// A time series of nodal (and cell) fields for ParaView: FOLDER/NAME.xdmf describes FOLDER/NAME.h5. Everything is
/// gathered on rank 0 of the communicator, which alone touches the file system. In the HDF5 file: `mesh/points`,
/// `mesh/cells` (VTK's order of vertices) and a group of fields an instant, `000000`, `000001`, ..., with the attribute
/// `time`; each field has the attribute `unit`, which ParaView shows with its name: "velocity [m/s]".
///
/// All of it can be read at any time: mesh and instants are files of their own in FOLDER/NAME.parts-N, N one more than
/// that of the run before, written aside and renamed, and never touched again; NAME.h5 links to them and is renamed
/// into place likewise, after each instant. Collective. Throws Failure(file).
class FieldWriter {
 public:
  FieldWriter(MPI_Comm communicator, const std::string &folder, const std::string &name, const OutputMesh &mesh);
  ~FieldWriter();
  /// Of a run that goes on from this time [s]: the series keeps what the run before wrote up to then.
  void go_on_from(double time);
  /// Opens a new time instant; fields follow.
  void begin(double time);
  /// `values`: [owned node][components], 1 or 3 components, in this unit; "1" of a mere number.
  void nodal(const std::string &field, const std::string &unit, unsigned components, const double *values);
  /// `values`: [owned cell][components].
  void cellwise(const std::string &field, const std::string &unit, unsigned components, const double *values);
  /// Closes the instant and shows it in the series.
  void end();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Removes the parts of earlier runs to which no series of the folder links; those of the run just before remain for
/// readers who have its series open.
void remove_old_parts(const std::string &folder);

} // namespace heartbus::io
