#pragma once

#include "common/base/stopwatch.h"
#include "common/fem/constraints.h"
#include "common/fem/time_history.h"
#include "common/fibres/fibres.h"
#include "common/linear_algebra/linear_solver.h"
#include "common/nonlinear/newton.h"
#include "mech_solver/boundary_terms.h"
#include "mech_solver/elasticity_kernel.h"
#include "mech_solver/material_regions.h"
#include "mech_solver/tangent_solver.h"

namespace heartbus::mech {

/// The elastodynamics equation by implicit Euler (paper, eq. (elastodynamics-discrete)): find d = d^{n+1} with
///
///     int rho (d - 2 d^n + d^{n-1})/dt^2 . phi + int P(d, T) : grad phi + pericardium(d, (d - d^n)/dt; phi)
///         + loads(d; phi) = load(phi) + int rho gravity . phi,
///
/// or, without inertia and damping, its quasi-static form. The mass is consistent. Newton's method (fem::newton) sees
/// this class as residual, linearise, solve and size; tangent and preconditioner live here and are kept from step to
/// step until Newton finds them too old.
class ElasticityProblem {
 public:
  ElasticityProblem(const fem::LagrangeSpace &space, const fem::Fibres &fibres, const Parameters &parameters);

  // The state, three components a node, and what acts on it. Values of owned nodes are the caller's to set.
  fem::TimeHistory past;         ///< old displacements d^n, d^{n-1}, d^{n-2}, d^{n-3} [m]
  fem::Vector tension;           ///< active tension at the nodes, one component [Pa]
  fem::Vector load;              ///< nodal forces on the solid [N]
  double interface_pressure = 0; ///< a follower pressure [Pa]
  double time = 0;               ///< at which the scene's loads are taken [s]
  double load_share = 1;         ///< of the scene's loads and of gravity, while inflating
  bus::Stopwatch stopwatch;

  /// Solve for d, starting from its value.
  fem::NewtonStatistics solve_dynamic(double dt, fem::Vector &d);
  fem::NewtonStatistics solve_static(fem::Vector &d);
  /// The next solve makes tangent and preconditioner anew.
  void forget_tangent();
  /// For those who run Newton's method on more than the solid: what solve_dynamic does first.
  void begin_dynamic(double dt);
  fem::NewtonSettings newton_settings() const;
  /// tangent dx = force, starting from dx, to the linear solver's tolerance or to this one if that is larger. Returns
  /// the iterations.
  unsigned solve_tangent(fem::Vector &dx, const fem::Vector &force, double tolerance = 0);
  /// Which solves with the tangent.
  TangentSolver &tangent_solver() { return tangent_solver_; }
  const TangentSolver &tangent_solver() const { return tangent_solver_; }
  // Of the last displacement looked at, this rank.
  double smallest_J() const { return smallest_J_; }
  double own_volume() const { return own_volume_; } ///< of its own cells [m^3]
  double own_volume_at_rest() const;

  /// Static nodal forces of the solid: stress, pericardium, the scene's loads; zero at constrained degrees of freedom.
  void solid_forces(const fem::Vector &d, fem::Vector &r);
  /// int P_act(d, tension_change) : grad phi; zero at constrained degrees of freedom.
  void active_forces(const fem::Vector &d, const fem::Vector &tension_change, fem::Vector &r) const;
  /// Fibre stretch sqrt(I4f) at the nodes, by lumped L2 projection of I4f = |F f0|^2; 1 where nothing contracts.
  void fibre_stretch(const fem::Vector &d, fem::Vector &stretch) const;
  /// Of the interface as d^n moves it, on the blood: the solid's own boundary term, free degrees of freedom only.
  fem::Vector unit_pressure_force() const;
  /// int J F^{-T} N phi over the interface as d moves it, N out of the wall; all degrees of freedom.
  fem::Vector interface_area(const fem::Vector &d) const;
  const fem::Constraints &constrained() const { return constrained_; }
  const fem::LagrangeSpace &space() const { return space_; }
  const fem::BlockMatrix<double> &tangent() const { return tangent_; } ///< as of the last `linearise`
  void apply_tangent(fem::Vector &y, const fem::Vector &x) const { rounded_tangent_.vmult(y, x); }

  // Newton's view
  fem::ResidualSize residual(const fem::Vector &d, fem::Vector &r);
  bool has_tangent() const { return has_tangent_; }
  unsigned n_tangents() const { return n_tangents_; } ///< so far: tells whether there is a new one
  void linearise(const fem::Vector &d);
  unsigned solve(fem::Vector &dx, const fem::Vector &r);
  double size(const fem::Vector &dx) const { return dx.linfty_norm(); }
  /// Throws Failure(not_finite) naming the worst cell when the last displacement looked at crushes or stretches one
  /// beyond what the constitutive laws are evaluated for. Collective.
  void refuse() const;

 private:
  struct CellData; // nodal values of one batch
  struct Load {
    LoadParameters parameters;
    LoadedSurface surface;
  };

  void add_loads(const fem::Vector &d, fem::Vector &r) const;
  void constrain(const Parameters &parameters);
  void set_mode(double dt); ///< 0: quasi-static
  void update_time_terms(const fem::Vector &d);
  ElasticityCells gather(unsigned batch, const MaterialRegion &region, const fem::Vector &d, const fem::Vector &tension,
                         CellData &data) const;
  void scatter(unsigned batch, const VectorizedDouble *values, unsigned components, fem::Vector &r) const;
  void add_cells(const fem::Vector &d, fem::Vector &r);
  void note_limits(unsigned batch, const DeformationLimits &limits);
  std::array<double, 6> centre(unsigned slot, const fem::Vector &d) const; ///< at rest, and its displacement [m]

  const fem::LagrangeSpace &space_;
  const fem::Fibres &fibres_;
  const SolverParameters solver_;
  const fem::Vec3<double> gravity_; ///< [m/s^2]
  const bool mean_dilatation_;
  const ActiveFibres active_fibres_;
  std::vector<MaterialRegion> regions_;
  Pericardium pericardium_;
  std::vector<LoadedSurface> interface_; ///< one, or none
  std::vector<Load> loads_;
  fem::Constraints constrained_;

  double negligible_force_; ///< [N]
  double dt_ = 0;
  fem::Vector acceleration_, velocity_;
  double smallest_J_ = 1, largest_exponent_ = 0, own_volume_ = 0;
  unsigned most_crushed_ = 0, most_stretched_ = 0;          ///< slots
  std::array<double, 6> crushed_cell_{}, stretched_cell_{}; ///< centre at rest, displacement: of what is refused [m]

  fem::BlockMatrix<double> tangent_;
  fem::BlockMatrix<float> rounded_tangent_; ///< for iterations
  bool has_tangent_ = false;
  unsigned n_tangents_ = 0;
  TangentSolver tangent_solver_;
  double wanted_residual_ = 0; ///< of Newton's method, at the last state looked at
};

} // namespace heartbus::mech
