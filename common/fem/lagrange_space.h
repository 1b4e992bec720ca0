#pragma once

#include "common/geometry/mesh.h"
#include "common/simd/vectorized_double.h"

#include <deal.II/base/partitioner.h>
#include <deal.II/lac/la_parallel_vector.h>

#include <cstdint>
#include <memory>
#include <mpi.h>
#include <string>
#include <vector>

namespace heartbus::fem {

using Vector = dealii::LinearAlgebra::distributed::Vector<double>;

/// Ghost values of a vector for the time of a scope. While they are on, deal.II renews them after each change of the
/// vector and of its copies, each time by a message.
class GhostValues {
 public:
  explicit GhostValues(const Vector &v) : v_(v), were_on_(v.has_ghost_elements()) { v.update_ghost_values(); }
  GhostValues(const GhostValues &) = delete;
  ~GhostValues() {
    if (!were_on_)
      v_.zero_out_ghost_values();
  }

 private:
  const Vector &v_;
  const bool were_on_;
};

/// Copies the owned values alone; ghost values of the target are off.
inline void copy_owned(const Vector &from, Vector &to) {
  to.zero_out_ghost_values();
  to.copy_locally_owned_data_from(from);
}

/// The faces of one boundary label that belong to this rank's cells (see LagrangeSpace), with all that surface
/// integrals over the reference configuration need. Index f runs over faces, q over quadrature points, a over nodes
/// of the cell.
struct BoundaryFaces {
  unsigned n_faces = 0, n_q = 0, nodes_per_cell = 0;
  std::vector<unsigned> slots;      ///< [f] cell slot
  std::vector<std::uint8_t> owned;  ///< [f] whether this rank owns the cell: sum functionals over owned faces only
  std::vector<double> JxW;          ///< [f][q] reference area times weight
  std::vector<double> normals;      ///< [f][q][3] outward, reference
  std::vector<double> shapes;       ///< [f][q][a]
  std::vector<double> gradients;    ///< [f][q][a][3]
  std::vector<unsigned> face_nodes; ///< [f][k] those cell node indices a that lie on the face
  unsigned nodes_per_face = 0;
};

/// Scalar Lagrange elements on a distributed mesh at rest. Every field of the program is nodal on such a space: a field
/// of b components has b interleaved values a node (local index node*b + component). The mesh never moves (kernels
/// integrate on the reference cells), so shape gradients and weights are computed once and kept.
///
/// Nodes: local numbering, owned first, then ghosts. Cells: those owned, then those ghost cells that touch an owned
/// node; so every row of an owned node can be assembled completely here, without communication. Cells sit in *slots*,
/// four (n_lanes) slots to a *batch*; unused slots at the end of the owned and of the ghost batches have JxW = 0 and
/// repeat the nodes of a real cell.
///
/// Finite element, quadrature, mapping and partition are chosen in lagrange_space.cpp and nowhere else.
class LagrangeSpace {
 public:
  /// Collective. `mesh`: whole on the first rank; of the others kind, labels and names count. `refinements`: uniform,
  /// nested. `degree`: 1, or 2 on tetrahedra. Throws Failure when a mesh is invalid.
  LagrangeSpace(MPI_Comm communicator, const geometry::Mesh &mesh, unsigned refinements = 0, unsigned degree = 1);
  ~LagrangeSpace();

  MPI_Comm communicator() const { return communicator_; }
  bool is_root() const;

  // nodes
  unsigned n_owned_nodes() const { return n_owned_nodes_; }
  unsigned n_local_nodes() const { return n_local_nodes_; }
  std::uint64_t n_global_nodes() const;
  std::uint64_t first_owned_node() const; ///< global number of local node 0; owned numbers are contiguous
  std::uint64_t global_node(unsigned local) const;
  const std::vector<geometry::Point3> &points() const { return points_; } ///< [local node], reference [m]

  /// A zero vector of `components` interleaved values a node, with ghosts. Raw access: v.begin()[node*components + c]
  /// for every local node (ghosts valid after update_ghost_values()).
  Vector make_vector(unsigned components) const;
  std::shared_ptr<const dealii::Utilities::MPI::Partitioner> partitioner(unsigned components) const;

  // cells
  unsigned nodes_per_cell() const { return nodes_per_cell_; }
  unsigned n_q() const { return n_q_; }
  unsigned n_batches() const { return n_batches_; }
  unsigned n_owned_batches() const { return n_owned_batches_; }
  unsigned n_slots() const { return n_batches_ * n_lanes; }
  bool slot_used(unsigned slot) const { return slot_used_[slot]; }
  bool slot_owned(unsigned slot) const { return slot_used_[slot] && slot < n_owned_batches_ * n_lanes; }
  std::uint64_t n_global_cells() const { return n_global_cells_; }
  const unsigned *cell_nodes(unsigned slot) const { return cell_nodes_.data() + slot * nodes_per_cell_; }
  unsigned material(unsigned slot) const { return materials_[slot]; }
  const std::vector<std::string> &material_names() const { return material_names_; }
  /// What the mesh brings along for the cell, where it does: null when it does not.
  const geometry::Mesh::Fibre *fibre(unsigned slot) const { return fibres_.empty() ? nullptr : &fibres_[slot]; }
  /// [q][a], the same for all cells
  const double *shapes() const { return shapes_.data(); }
  /// [q][a][3] of a batch, in VectorizedDouble [1/m]
  const VectorizedDouble *gradients(unsigned batch) const {
    return gradients_.data() + std::size_t(batch) * n_q_ * nodes_per_cell_ * 3;
  }
  /// [q] of a batch [m^3]; zero in unused slots
  const VectorizedDouble *JxW(unsigned batch) const { return JxW_.data() + std::size_t(batch) * n_q_; }
  /// Coordinates of quadrature point q of a slot, reference [m].
  geometry::Point3 quadrature_point(unsigned slot, unsigned q) const;
  /// Edge length of the cell: (volume)^(1/3) [m].
  double cell_size(unsigned slot) const;
  double smallest_cell_size() const { return smallest_cell_size_; } ///< over all ranks

  // boundary
  bool has_label(const std::string &label) const;
  const std::vector<std::string> &labels() const { return labels_; }
  /// Throws Failure(scene) listing the labels there are when `label` does not exist.
  BoundaryFaces faces(const std::string &label) const;
  /// 1 for every local node (ghosts too) on a face of the label, else 0.
  std::vector<std::uint8_t> nodes_on(const std::string &label) const;

 private:
  void distribute(const geometry::Mesh &mesh, unsigned refinements);
  void number_nodes();
  void collect_cells();
  void fetch_cell_data(const geometry::Mesh &mesh);
  void cache_geometry();
  double find_smallest_cell_size() const;
  unsigned label_id(const std::string &label) const;
  unsigned nodes_per_face() const;

  struct Discretisation; // deal.II's triangulation, dof handler, element, mapping, quadratures
  std::unique_ptr<Discretisation> discretisation_;
  MPI_Comm communicator_;
  unsigned degree_;
  std::vector<std::string> labels_, material_names_;
  double smallest_cell_size_ = 0;
  unsigned n_owned_nodes_ = 0, n_local_nodes_ = 0, nodes_per_cell_ = 0, n_q_ = 0, n_batches_ = 0, n_owned_batches_ = 0;
  std::uint64_t n_global_cells_ = 0;
  std::vector<geometry::Point3> points_;
  std::vector<std::uint8_t> slot_used_;
  std::vector<unsigned> cell_nodes_, materials_;
  std::vector<geometry::Mesh::Fibre> fibres_;
  std::vector<double> shapes_;
  std::vector<VectorizedDouble> gradients_, JxW_;
  mutable std::vector<std::shared_ptr<const dealii::Utilities::MPI::Partitioner>> partitioners_;
};

} // namespace heartbus::fem
