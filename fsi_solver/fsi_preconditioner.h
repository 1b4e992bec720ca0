#pragma once

#include "common/linear_algebra/linear_solver.h"
#include "common/linear_algebra/preconditioner_age.h"
#include "fluid_solver/navier_stokes_problem.h"
#include "fsi_solver/merged_space.h"
#include "mech_solver/elasticity_problem.h"

namespace heartbus::fsi {

/// Blocks between neighbouring interface nodes of a matrix of the solid, carried to the fluid's rows.
class InterfaceBlocks {
 public:
  explicit InterfaceBlocks(const MergedSpace &space);
  /// fluid += factor * solid between interface nodes; pairs that the fluid's mesh does not join are left out.
  /// Collective.
  void add(double factor, const fem::BlockMatrix<double> &solid, fem::BlockMatrix<double> &fluid) const;

 private:
  const InterfaceMap &map_;
  unsigned width_ = 0;                                  ///< largest number of neighbours
  std::vector<std::vector<unsigned>> solid_neighbours_; ///< [owned interface node] local nodes of the solid
  std::vector<unsigned> fluid_neighbours_; ///< [owned interface node][width] local nodes of the fluid, or none
};

/// Block Gauss-Seidel for the merged system [A_f + dt S_GG, S_GI; dt S_IG, S_II] (x_f, d_I), where S is the solid's
/// tangent, split into interface and rest: first the blood, which carries the wall's interface block as an added mass,
/// then the wall with the interface where the blood takes it.
class FsiPreconditioner : public fem::Preconditioner {
 public:
  FsiPreconditioner(const MergedSpace &space, const InterfaceBlocks &interface, const fluid::NavierStokesProblem &fluid,
                    const mech::ElasticityProblem &solid, double dt);
  /// From the present matrices. The fluid's may change afterwards; so may the solid's, whose present values couple the
  /// blocks. Collective.
  void make();
  void vmult(fem::Vector &y, const fem::Vector &x) const override;

 private:
  const MergedSpace &space_;
  const InterfaceBlocks &interface_;
  const fluid::NavierStokesProblem &fluid_problem_;
  const mech::ElasticityProblem &solid_problem_;
  double dt_;
  fem::Constraints on_interface_;         ///< of the solid
  fem::BlockMatrix<double> fluid_matrix_; ///< with the wall's interface block as an added mass
  fem::BlockMatrix<double> solid_matrix_; ///< the tangent with the interface held
  std::unique_ptr<fem::Preconditioner> fluid_preconditioner_, solid_preconditioner_;
  mutable fem::Vector r_f_, z_f_, r_s_, z_s_, coupling_;
};

} // namespace heartbus::fsi
