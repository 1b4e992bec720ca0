#pragma once

#include "common/geometry/mesh_tools.h"
#include "mech_solver/interface_wall.h"

#include <functional>

/// An elastic body that tests load with what an exact solution asks for.
namespace heartbus::mech {

using fem::n_lanes;
using fem::Vec3;
using Matrix = Mat3<double>;
using Field = std::function<Vec3<double>(const geometry::Point3 &)>;
using MatrixField = std::function<Matrix(const geometry::Point3 &)>;

inline const std::vector<std::string> all_sides{"x_low", "x_high", "y_low", "y_high", "z_low", "z_high"};

inline Parameters soft_neo_hookean() {
  Parameters parameters;
  parameters.law = "neo_hookean";
  parameters.neo_hookean = {12e3, 50e3}; // kappa + 4 mu / 3 = 66 kPa
  parameters.fixed = {};
  parameters.pericardium.labels = {};
  parameters.solver.residual_tolerance = 1e-10;
  parameters.solver.linear_tolerance = 1e-6;
  return parameters;
}

inline geometry::FibreParameters oblique_fibres() {
  geometry::FibreParameters fibres;
  fibres.rule = "constant";
  fibres.direction = {1, 2, 3};
  fibres.sheet = {3, 0, -1};
  return fibres;
}

/// Renames boundary labels, several to the same name if wanted.
inline geometry::Mesh relabelled(geometry::Mesh mesh, const std::string &from, const std::string &to) {
  const auto at = [&](const std::string &label) {
    return unsigned(std::find(mesh.labels.begin(), mesh.labels.end(), label) - mesh.labels.begin());
  };
  const unsigned old_id = at(from), new_id = at(to);
  if (new_id == mesh.labels.size())
    mesh.labels.push_back(to);
  for (auto &face : mesh.faces)
    if (face.label == old_id)
      face.label = new_id;
  return mesh;
}

struct Body {
  Body(const geometry::Mesh &mesh, const Parameters &parameters)
      : space(MPI_COMM_WORLD, mesh), fibres(space, oblique_fibres()), problem(space, fibres, parameters) {}

  fem::Vector interpolate(const Field &field) const {
    fem::Vector v = space.make_vector(3);
    for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
      for (unsigned i = 0; i < 3; ++i)
        v.begin()[3 * node + i] = field(space.points()[node])[i];
    return v;
  }
  /// load += int density . phi
  void add_volume_load(const Field &density) {
    for (unsigned slot = 0; slot < space.n_slots(); ++slot)
      for (unsigned q = 0; q < space.n_q() && space.slot_used(slot); ++q) {
        const Vec3<double> f = density(space.quadrature_point(slot, q));
        add(space.cell_nodes(slot), space.shapes() + q * space.nodes_per_cell(),
            space.JxW(slot / n_lanes)[q][slot % n_lanes], f);
      }
  }
  /// load += int (traction(x) n + extra(x)) . phi over the faces of a label
  void add_surface_load(const std::string &label, const MatrixField &stress, const MatrixField &robin_rate) {
    const fem::BoundaryFaces faces = space.faces(label);
    for (unsigned f = 0; f < faces.n_faces; ++f)
      for (unsigned q = 0; q < faces.n_q; ++q) {
        const unsigned fq = f * faces.n_q + q;
        const double *shape = &faces.shapes[fq * faces.nodes_per_cell], *n = &faces.normals[3 * fq];
        geometry::Point3 x{};
        for (unsigned a = 0; a < faces.nodes_per_cell; ++a)
          for (unsigned i = 0; i < 3; ++i)
            x[i] += shape[a] * space.points()[space.cell_nodes(faces.slots[f])[a]][i];
        const Vec3<double> normal = {n[0], n[1], n[2]};
        Vec3<double> t = stress(x) * normal;
        if (robin_rate) { // columns: what the springs along and across the normal pull at
          const Matrix pull = robin_rate(x);
          for (unsigned i = 0; i < 3; ++i)
            for (unsigned j = 0; j < 3; ++j)
              t[i] += normal[i] * normal[j] * pull[j][0] + ((i == j) - normal[i] * normal[j]) * pull[j][1];
        }
        add(space.cell_nodes(faces.slots[f]), shape, faces.JxW[fq], t);
      }
  }
  double error(const fem::Vector &d, const Field &exact) const {
    d.update_ghost_values();
    double sum = 0;
    for (unsigned slot = 0; slot < space.n_slots(); ++slot)
      for (unsigned q = 0; q < space.n_q() && space.slot_owned(slot); ++q)
        for (unsigned i = 0; i < 3; ++i) {
          double value = -exact(space.quadrature_point(slot, q))[i];
          for (unsigned a = 0; a < space.nodes_per_cell(); ++a)
            value += space.shapes()[q * space.nodes_per_cell() + a] * d.begin()[3 * space.cell_nodes(slot)[a] + i];
          sum += space.JxW(slot / n_lanes)[q][slot % n_lanes] * value * value;
        }
    return std::sqrt(dealii::Utilities::MPI::sum(sum, MPI_COMM_WORLD));
  }

  fem::LagrangeSpace space;
  fem::Fibres fibres;
  ElasticityProblem problem;

 private:
  void add(const unsigned *nodes, const double *shape, double weight, const Vec3<double> &f) {
    for (unsigned a = 0; a < space.nodes_per_cell(); ++a)
      for (unsigned i = 0; i < 3 && nodes[a] < space.n_owned_nodes(); ++i)
        problem.load.begin()[3 * nodes[a] + i] += weight * shape[a] * f[i];
  }
};

} // namespace heartbus::mech
