#pragma once

#include "common/fem/constraints.h"
#include "common/fem/lagrange_space.h"
#include "common/linear_algebra/block_matrix.h"

#include <array>
#include <string>
#include <vector>

namespace heartbus::fluid {

/// The faces of a boundary label on the moved mesh, by Nanson's formula n da = J F^{-T} N dA at the quadrature points
/// of the faces at rest. Vectors hold four components a node, of which the first three are a velocity or a force.
class MovedSurface {
 public:
  MovedSurface(const fem::LagrangeSpace &space, const std::string &label);

  /// Takes the motion d (three components a node, ghosts valid). Call before anything below.
  void move(const fem::Vector &ale_displacement);

  /// |n da| at each quadrature point, and u.n da; both [f][q] with the quadrature weight.
  std::vector<double> areas() const;
  std::vector<double> fluxes(const fem::Vector &u) const;

  /// int |u.n| and int |u|^2 |u.n| / 2 where u points inwards, over the faces of this rank's cells; ghosts of u valid.
  std::array<double, 2> inflow(const fem::Vector &u) const;

  /// c.u = int u.n for every u: the entries of this rank's nodes.
  fem::Vector flux_functional() const;
  /// c.x = int p |n da| over the area, the mean pressure of a state x [unit of p]: the entries of this rank's nodes;
  /// `area` as the sum of `areas` over all ranks.
  fem::Vector pressure_functional(double area) const;
  /// The sum of weights [f][q] over the cells of this rank.
  double owned_sum(const std::vector<double> &weights) const;
  /// int w N_k N_l between the nodes of each face, [f][k][l], with the weights w [f][q] including the area, as `areas`
  /// and `fluxes` return it.
  std::vector<double> masses(const std::vector<double> &weights) const;
  /// A += int w u.v
  void add_mass(const std::vector<double> &masses, fem::BlockMatrix<float> &A) const;
  /// y += the same form times x (ghosts of x valid), on this rank's nodes.
  void apply_mass(const std::vector<double> &masses, const fem::Vector &x, fem::Vector &y) const;

 private:
  unsigned cell_node(unsigned f, unsigned k) const { return faces_.face_nodes[f * faces_.nodes_per_face + k]; }
  unsigned node(unsigned f, unsigned k) const { return space_.cell_nodes(faces_.slots[f])[cell_node(f, k)]; }
  double shape(unsigned f, unsigned q, unsigned k) const {
    return faces_.shapes[(f * faces_.n_q + q) * faces_.nodes_per_cell + cell_node(f, k)];
  }

  const fem::LagrangeSpace &space_;
  fem::BoundaryFaces faces_;
  std::vector<geometry::Point3> area_vectors_; ///< [f][q] n da
};

} // namespace heartbus::fluid
