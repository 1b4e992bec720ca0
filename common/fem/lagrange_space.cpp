#include "common/fem/lagrange_space.h"

#include "common/base/failure.h"
#include "common/fem/on_root.h"
#include "common/fem/partition.h"

#include <deal.II/distributed/fully_distributed_tria.h>
#include <deal.II/dofs/dof_handler.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/fe_simplex_p.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/fe/mapping_fe.h>
#include <deal.II/grid/grid_generator.h>
#include <deal.II/grid/grid_tools.h>
#include <deal.II/grid/tria_description.h>

#include <map>

namespace heartbus::fem {

using dealii::numbers::invalid_unsigned_int;

struct LagrangeSpace::Discretisation {
  explicit Discretisation(MPI_Comm communicator) : triangulation(communicator), dof_handler(triangulation) {}

  dealii::parallel::fullydistributed::Triangulation<3> triangulation;
  dealii::DoFHandler<3> dof_handler;
  std::unique_ptr<dealii::FiniteElement<3>> element;
  std::unique_ptr<dealii::Mapping<3>> mapping;
  dealii::Quadrature<3> quadrature;
  dealii::Quadrature<2> face_quadrature;
  std::vector<dealii::DoFHandler<3>::active_cell_iterator> cells; ///< [slot]
};

namespace {

/// The symmetric rule of degree 2 on the unit simplex, a point for each vertex (Hammer, Stroud 1956, Math. Tables Aids
/// Comput. 10). QGaussSimplex of deal.II 9.4 is of degree 3, but not symmetric, and has half as many points again.
template <int dim>
dealii::Quadrature<dim> quadratic_rule() {
  const double other = (dim + 2 - std::sqrt(dim + 2.)) / ((dim + 1) * (dim + 2)), own = 1 - dim * other,
               weight = (dim == 3 ? 1. / 6 : 1. / 2) / (dim + 1);
  std::vector<dealii::Point<dim>> points(dim + 1); // the first vertex is the origin
  for (unsigned vertex = 0; vertex <= dim; ++vertex)
    for (unsigned i = 0; i < dim; ++i)
      points[vertex][i] = i + 1 == vertex ? own : other;
  return dealii::Quadrature<dim>(points, std::vector<double>(dim + 1, weight));
}

} // namespace

LagrangeSpace::LagrangeSpace(MPI_Comm communicator, const geometry::Mesh &mesh, unsigned refinements, unsigned degree)
    : discretisation_(std::make_unique<Discretisation>(communicator)), communicator_(communicator), degree_(degree),
      labels_(mesh.labels), material_names_(mesh.material_names) {
  auto &d = *discretisation_;
  if (mesh.kind == geometry::Mesh::CellKind::hexahedron) {
    if (degree != 1)
      throw Failure(ExitCode::scene, "hexahedra have elements of degree 1; refine the mesh instead");
    d.element = std::make_unique<dealii::FE_Q<3>>(1);
    d.mapping = std::make_unique<dealii::MappingQ<3>>(1);
    d.quadrature = dealii::QGauss<3>(2);
    d.face_quadrature = dealii::QGauss<2>(2);
  } else {
    d.element = std::make_unique<dealii::FE_SimplexP<3>>(degree);
    d.mapping = std::make_unique<dealii::MappingFE<3>>(dealii::FE_SimplexP<3>(1));
    // Symmetric, so that the numbering of a cell's vertices does not matter, and exact for masses.
    if (degree == 1) {
      d.quadrature = quadratic_rule<3>();
      d.face_quadrature = quadratic_rule<2>();
    } else {
      d.quadrature = dealii::QWitherdenVincentSimplex<3>(3);
      d.face_quadrature = dealii::QWitherdenVincentSimplex<2>(3);
    }
  }
  distribute(mesh, refinements);
  number_nodes();
  collect_cells();
  fetch_cell_data(mesh);
  cache_geometry();
  smallest_cell_size_ = find_smallest_cell_size();
}

LagrangeSpace::~LagrangeSpace() = default;

bool LagrangeSpace::is_root() const { return dealii::Utilities::MPI::this_mpi_process(communicator_) == 0; }

namespace {

/// The labels of the mesh on the boundary of its triangulation: looked up by sorted vertices, so that no orientation
/// rule matters.
void label_boundary(const geometry::Mesh &mesh, dealii::Triangulation<3> &triangulation) {
  std::map<std::vector<unsigned>, unsigned> label_of_face;
  for (const auto &face : mesh.faces) {
    std::vector<unsigned> key(face.vertices.begin(), face.vertices.begin() + mesh.vertices_per_face());
    std::sort(key.begin(), key.end());
    label_of_face[key] = face.label;
  }
  for (const auto &face : triangulation.active_face_iterators())
    if (face->at_boundary()) {
      std::vector<unsigned> key;
      for (const unsigned v : face->vertex_indices())
        key.push_back(face->vertex_index(v));
      std::sort(key.begin(), key.end());
      const auto found = label_of_face.find(key);
      if (found == label_of_face.end())
        throw Failure(ExitCode::scene, "the mesh has a boundary face without a label");
      face->set_boundary_id(found->second + 1); // 0: what deal.II gives to the outside of the ghost cells
    }
}

/// Built, refined, flattened: one path for hexahedra and tetrahedra.
void make_triangulation(const geometry::Mesh &mesh, unsigned refinements, dealii::Triangulation<3> &flat) {
  const unsigned per_cell = mesh.vertices_per_cell();
  std::vector<dealii::Point<3>> vertices;
  for (const auto &x : mesh.points)
    vertices.emplace_back(x[0], x[1], x[2]);
  std::vector<dealii::CellData<3>> cells;
  for (std::size_t c = 0; c < mesh.n_cells(); ++c) {
    cells.emplace_back(per_cell);
    for (unsigned v = 0; v < per_cell; ++v)
      cells.back().vertices[v] = mesh.cells[c * per_cell + v];
    cells.back().material_id = c; // which children inherit: see fetch_cell_data
  }
  if (mesh.kind == geometry::Mesh::CellKind::hexahedron)
    dealii::GridTools::consistently_order_cells(cells);
  dealii::Triangulation<3> coarse;
  coarse.create_triangulation(vertices, cells, dealii::SubCellData());
  label_boundary(mesh, coarse);
  coarse.refine_global(refinements);
  dealii::GridGenerator::flatten_triangulation(coarse, flat);
}

} // namespace

/// One rank alone holds the whole triangulation, partitions it and hands out the parts: memory of the others falls with
/// their number.
void LagrangeSpace::distribute(const geometry::Mesh &mesh, unsigned refinements) {
  const int n_ranks = dealii::Utilities::MPI::n_mpi_processes(communicator_);
  dealii::Triangulation<3> flat;
  on_root(communicator_, [&] {
    make_triangulation(mesh, refinements, flat);
    partition(flat, n_ranks);
  });
  discretisation_->triangulation.create_triangulation(
      dealii::TriangulationDescription::Utilities::create_description_from_triangulation_in_groups<3, 3>(
          [&flat](dealii::Triangulation<3> &whole) {
            whole.copy_triangulation(flat);
            flat.clear();
          },
          [](dealii::Triangulation<3> &, const MPI_Comm &, unsigned) {}, communicator_, n_ranks));
  n_global_cells_ = discretisation_->triangulation.n_global_active_cells();
}

void LagrangeSpace::number_nodes() {
  auto &d = *discretisation_;
  d.dof_handler.distribute_dofs(*d.element);
  dealii::IndexSet relevant;
  dealii::DoFTools::extract_locally_relevant_dofs(d.dof_handler, relevant);
  partitioners_.resize(5);
  partitioners_[1] = std::make_shared<const dealii::Utilities::MPI::Partitioner>(d.dof_handler.locally_owned_dofs(),
                                                                                 relevant, communicator_);
  n_owned_nodes_ = partitioners_[1]->locally_owned_size();
  n_local_nodes_ = n_owned_nodes_ + partitioners_[1]->n_ghost_indices();
  nodes_per_cell_ = d.element->n_dofs_per_cell();

  points_.resize(n_local_nodes_);
  std::vector<dealii::types::global_dof_index> nodes(nodes_per_cell_);
  for (const auto &cell : d.dof_handler.active_cell_iterators()) {
    if (cell->is_artificial())
      continue;
    cell->get_dof_indices(nodes);
    for (unsigned a = 0; a < nodes_per_cell_; ++a) {
      // Vertices are copied, not mapped: coordinates must agree bitwise between participants.
      const dealii::Point<3> x = a < cell->n_vertices()
                                     ? cell->vertex(a)
                                     : d.mapping->transform_unit_to_real_cell(cell, d.element->unit_support_point(a));
      points_[partitioners_[1]->global_to_local(nodes[a])] = {x[0], x[1], x[2]};
    }
  }
}

void LagrangeSpace::collect_cells() {
  auto &d = *discretisation_;
  std::vector<dealii::types::global_dof_index> nodes(nodes_per_cell_);
  const auto touches_owned_node = [&](const auto &cell) {
    cell->get_dof_indices(nodes);
    return std::any_of(nodes.begin(), nodes.end(), [&](auto i) { return partitioners_[1]->in_local_range(i); });
  };
  const auto pad = [&] {
    while (!d.cells.empty() && d.cells.size() % n_lanes != 0) {
      d.cells.push_back(d.cells.back());
      slot_used_.push_back(0);
    }
    return unsigned(d.cells.size() / n_lanes);
  };
  const auto append = [&](const auto &cell) {
    d.cells.push_back(cell);
    slot_used_.push_back(1);
  };
  for (const auto &cell : d.dof_handler.active_cell_iterators())
    if (cell->is_locally_owned())
      append(cell);
  n_owned_batches_ = pad();
  for (const auto &cell : d.dof_handler.active_cell_iterators())
    if (cell->is_ghost() && touches_owned_node(cell))
      append(cell);
  n_batches_ = pad();

  for (const auto &cell : d.cells) {
    cell->get_dof_indices(nodes);
    for (const auto node : nodes)
      cell_nodes_.push_back(partitioners_[1]->global_to_local(node));
  }
}

/// The first rank alone knows what belongs to the cells of the mesh. It is asked for that of the cells here, by their
/// numbers, which travel as deal.II's material.
void LagrangeSpace::fetch_cell_data(const geometry::Mesh &mesh) {
  using Wanted = std::vector<unsigned>;
  using Found = std::pair<std::vector<unsigned>, std::vector<geometry::Mesh::Fibre>>;
  Wanted wanted;
  for (const auto &cell : discretisation_->cells)
    wanted.push_back(cell->material_id());
  const auto asked = dealii::Utilities::MPI::some_to_some(communicator_, std::map<unsigned, Wanted>{{0, wanted}});
  std::map<unsigned, Found> answers;
  for (const auto &[rank, cells] : asked)
    for (const unsigned c : cells) {
      answers[rank].first.push_back(mesh.materials.empty() ? 0 : mesh.materials[c]);
      if (!mesh.fibres.empty())
        answers[rank].second.push_back(mesh.fibres[c]);
    }
  auto found = dealii::Utilities::MPI::some_to_some(communicator_, answers);
  materials_ = std::move(found[0].first);
  fibres_ = std::move(found[0].second);
}

void LagrangeSpace::cache_geometry() {
  auto &d = *discretisation_;
  dealii::FEValues<3> values(*d.mapping, *d.element, d.quadrature,
                             dealii::update_values | dealii::update_gradients | dealii::update_JxW_values);
  n_q_ = d.quadrature.size();
  gradients_.resize(std::size_t(n_batches_) * n_q_ * nodes_per_cell_ * 3);
  JxW_.resize(std::size_t(n_batches_) * n_q_);
  for (unsigned q = 0; q < n_q_; ++q)
    for (unsigned a = 0; a < nodes_per_cell_; ++a)
      shapes_.push_back(d.element->shape_value(a, d.quadrature.point(q)));
  for (unsigned slot = 0; slot < n_slots(); ++slot) {
    values.reinit(typename dealii::Triangulation<3>::cell_iterator(d.cells[slot]));
    const std::size_t batch = slot / n_lanes, lane = slot % n_lanes;
    for (unsigned q = 0; q < n_q_; ++q) {
      JxW_[batch * n_q_ + q][lane] = slot_used_[slot] ? values.JxW(q) : 0.0;
      for (unsigned a = 0; a < nodes_per_cell_; ++a)
        for (unsigned k = 0; k < 3; ++k)
          gradients_[((batch * n_q_ + q) * nodes_per_cell_ + a) * 3 + k][lane] = values.shape_grad(a, q)[k];
    }
  }
}

std::uint64_t LagrangeSpace::n_global_nodes() const { return partitioners_[1]->size(); }

std::uint64_t LagrangeSpace::first_owned_node() const { return partitioners_[1]->local_range().first; }

std::uint64_t LagrangeSpace::global_node(unsigned local) const { return partitioners_[1]->local_to_global(local); }

std::shared_ptr<const dealii::Utilities::MPI::Partitioner> LagrangeSpace::partitioner(unsigned components) const {
  if (components >= partitioners_.size())
    partitioners_.resize(components + 1);
  if (!partitioners_[components]) {
    const std::uint64_t n = n_global_nodes() * components, first = first_owned_node() * components;
    dealii::IndexSet owned(n), ghosts(n);
    owned.add_range(first, first + std::uint64_t(n_owned_nodes_) * components);
    for (unsigned node = n_owned_nodes_; node < n_local_nodes_; ++node)
      ghosts.add_range(global_node(node) * components, (global_node(node) + 1) * components);
    partitioners_[components] =
        std::make_shared<const dealii::Utilities::MPI::Partitioner>(owned, ghosts, communicator_);
  }
  return partitioners_[components];
}

Vector LagrangeSpace::make_vector(unsigned components) const { return Vector(partitioner(components)); }

geometry::Point3 LagrangeSpace::quadrature_point(unsigned slot, unsigned q) const {
  geometry::Point3 x{};
  for (unsigned a = 0; a < nodes_per_cell_; ++a)
    for (unsigned k = 0; k < 3; ++k)
      x[k] += shapes_[q * nodes_per_cell_ + a] * points_[cell_nodes(slot)[a]][k];
  return x;
}

double LagrangeSpace::cell_size(unsigned slot) const { return std::cbrt(discretisation_->cells[slot]->measure()); }

double LagrangeSpace::find_smallest_cell_size() const {
  double smallest = std::numeric_limits<double>::max();
  for (unsigned slot = 0; slot < n_slots(); ++slot)
    if (slot_used_[slot])
      smallest = std::min(smallest, cell_size(slot));
  return dealii::Utilities::MPI::min(smallest, communicator_);
}

bool LagrangeSpace::has_label(const std::string &label) const {
  return std::find(labels_.begin(), labels_.end(), label) != labels_.end();
}

unsigned LagrangeSpace::label_id(const std::string &label) const {
  const auto found = std::find(labels_.begin(), labels_.end(), label);
  if (found == labels_.end()) {
    std::string known;
    for (const auto &name : labels_)
      known += (known.empty() ? "" : ", ") + name;
    throw Failure(ExitCode::scene, "the mesh has no boundary label '" + label + "'; it has " + known);
  }
  return found - labels_.begin() + 1;
}

namespace {

/// Whether shape function a lives on the face. (deal.II 9.4 claims so for every one of a tetrahedron.)
bool is_on_face(const dealii::FEFaceValues<3> &values, unsigned a) {
  double largest = 0;
  for (const unsigned q : values.quadrature_point_indices())
    largest = std::max(largest, std::abs(values.shape_value(a, q)));
  return largest > 1e-10;
}

} // namespace

BoundaryFaces LagrangeSpace::faces(const std::string &label) const {
  const unsigned id = label_id(label);
  auto &d = *discretisation_;
  dealii::FEFaceValues<3> values(*d.mapping, *d.element, d.face_quadrature,
                                 dealii::update_values | dealii::update_gradients | dealii::update_JxW_values |
                                     dealii::update_normal_vectors);
  BoundaryFaces faces;
  faces.n_q = d.face_quadrature.size();
  faces.nodes_per_cell = nodes_per_cell_;
  for (unsigned slot = 0; slot < n_slots(); ++slot) {
    const typename dealii::Triangulation<3>::cell_iterator cell = d.cells[slot];
    if (!slot_used_[slot])
      continue;
    for (const unsigned f : cell->face_indices()) {
      if (!cell->face(f)->at_boundary() || cell->face(f)->boundary_id() != id)
        continue;
      values.reinit(cell, f);
      ++faces.n_faces;
      faces.slots.push_back(slot);
      faces.owned.push_back(slot_owned(slot));
      for (unsigned a = 0; a < nodes_per_cell_; ++a)
        if (is_on_face(values, a))
          faces.face_nodes.push_back(a);
      for (unsigned q = 0; q < faces.n_q; ++q) {
        faces.JxW.push_back(values.JxW(q));
        for (unsigned k = 0; k < 3; ++k)
          faces.normals.push_back(values.normal_vector(q)[k]);
        for (unsigned a = 0; a < nodes_per_cell_; ++a) {
          faces.shapes.push_back(values.shape_value(a, q));
          for (unsigned k = 0; k < 3; ++k)
            faces.gradients.push_back(values.shape_grad(a, q)[k]);
        }
      }
    }
  }
  faces.nodes_per_face = nodes_per_face();
  return faces;
}

unsigned LagrangeSpace::nodes_per_face() const { return nodes_per_cell_ == 8 ? 4 : degree_ == 1 ? 3 : 6; }

std::vector<std::uint8_t> LagrangeSpace::nodes_on(const std::string &label) const {
  const BoundaryFaces boundary = faces(label);
  Vector flags = make_vector(1);
  for (unsigned f = 0; f < boundary.n_faces; ++f)
    for (unsigned k = 0; k < boundary.nodes_per_face; ++k) {
      const unsigned node = cell_nodes(boundary.slots[f])[boundary.face_nodes[f * boundary.nodes_per_face + k]];
      if (node < n_owned_nodes_)
        flags.local_element(node) = 1;
    }
  flags.update_ghost_values();
  std::vector<std::uint8_t> on(n_local_nodes_);
  for (unsigned node = 0; node < n_local_nodes_; ++node)
    on[node] = flags.local_element(node) > 0.5;
  return on;
}

} // namespace heartbus::fem
