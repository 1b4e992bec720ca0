#pragma once

#include "common/linear_algebra/block_matrix.h"
#include "mech_solver/settings/parameters.h"

namespace heartbus::mech {

/// The pericardium on the epicardium (paper, eq. (pericardium)): with the outward reference normal n, over the
/// reference area,
///
///     P n = -(n x n) (K_perp d + C_perp d_t) - (I - n x n) (K_par d + C_par d_t).
///
/// It is linear: the face matrices are integrated once.
class Pericardium {
 public:
  Pericardium(const fem::LagrangeSpace &space, const PericardiumParameters &parameters);
  /// r += stiffness d + damping v; v may be null (statics). Ghosts of d and v must be up to date.
  void add_force(const fem::Vector &d, const fem::Vector *v, fem::Vector &r) const;
  /// K += stiffness + damping_factor * damping.
  void add_tangent(double damping_factor, fem::BlockMatrix<double> &K) const;

 private:
  struct Pair { // coupling between an owned node and another; slot, a, b: a cell that has both
    unsigned slot, a, b, row, column;
    std::array<double, 9> stiffness, damping;
  };
  void add_face(const fem::LagrangeSpace &space, const fem::BoundaryFaces &faces, unsigned f,
                const PericardiumParameters &parameters);
  void merge_pairs();
  std::vector<Pair> pairs_;
};

/// One label's part of the boundary, for loads on it. Pressure follows the surface: the load on the solid is
/// -int p J F^{-T} N . phi over the reference area. With w_b = F (N x grad phi_b), the derivative of J F^{-T} N in
/// direction e_j phi_b is the vector e_j x w_b.
class LoadedSurface {
 public:
  LoadedSurface(const fem::LagrangeSpace &space, const std::string &label);
  /// r += pressure * int J F^{-T} N . phi (an inner force: the load with its sign turned). Ghosts of d up to date.
  void add_force(double pressure, const fem::Vector &d, fem::Vector &r) const;
  void add_tangent(double pressure, const fem::Vector &d, fem::BlockMatrix<double> &K) const;
  /// r += int traction . phi over the area at rest.
  void add_traction(const fem::Vec3<double> &traction, fem::Vector &r) const;
  /// This rank's part of int (x n_x + y n_y) / 2 over the moved area: with flat lids across z the volume that
  /// the surface encloses, positive where its normals point outwards.
  double own_volume(const fem::Vector &d) const;
  /// y += int x . phi over the moved area. Ghosts of d and x up to date.
  void apply_mass(const fem::Vector &d, const fem::Vector &x, fem::Vector &y) const;

 private:
  Mat3<double> deformation(unsigned f, unsigned q, const fem::Vector &d) const;
  void add_face_tangent(unsigned f, double pressure, const fem::Vector &d, fem::BlockMatrix<double> &K) const;
  const fem::LagrangeSpace &space_;
  fem::BoundaryFaces faces_;
};

} // namespace heartbus::mech
