#pragma once

#include "common/base/stopwatch.h"
#include "common/fem/constraints.h"
#include "common/fem/time_history.h"
#include "common/interface/nodal/robin_condition.h"
#include "common/io/state.h"
#include "common/linear_algebra/linear_solver.h"
#include "common/linear_algebra/preconditioner_age.h"
#include "common/nonlinear/iterate_extrapolation.h"
#include "fluid_solver/models/navier_stokes_kernel.h"
#include "fluid_solver/moved_surface.h"
#include "fluid_solver/orifice.h"
#include "fluid_solver/settings/parameters.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace heartbus::fluid {

/// One step of the Navier-Stokes equations in the ALE frame with the Robin condition of the interface (paper, eq.
/// (navierstokes-discrete)), as forces on nodes: with a_f the stabilised momentum form of navier_stokes_kernel.h and
/// M_S the mass matrix of the moved interface, find u, p at t^{n+1} such that for all test functions
///
///     a_f(u, p; w, q) + alpha M_S u = g
///
/// and return the force on the solid L (common/interface/nodal/robin_condition.h has g and L).
/// L equals -a_f(u, p; w) on the interface's test functions: Robin-Neumann iterations end at the monolithic solution.
/// Vectors hold u, v, w, p at each node; the pressure is scaled (see pressure_scale).
class NavierStokesProblem {
 public:
  NavierStokesProblem(const fem::LagrangeSpace &space, const Parameters &parameters, double alpha, double dt);

  /// The Robin coefficient, from the next `prepare` on.
  void set_alpha(double alpha) { robin_.alpha = alpha; }
  double alpha() const { return robin_.alpha; }

  /// Without an old state, u^n = 0: the operator of motions that alternate from step to step, u^n = -u^{n+1}.
  void take_alternating_motion() { inertia_ = 2; }

  /// Instead of the Robin condition the blood on the interface moves as the mesh does, u = (d^{n+1} - d^n)/dt, whatever
  /// the wall says.
  void follow_motion();
  bool follows_motion() const { return follows_motion_; }
  /// By which the interface would enlarge the cavity if the mesh went on to this motion [m^3/s].
  double volume_rate(const fem::Vector &ale_displacement);
  /// Holds the velocities whose entries are not zero, as the wall does, whatever is open: those of the rim. Collective.
  void hold(const fem::Vector &held);
  /// Adds a valve or an opening; closed at first.
  Orifice &add_orifice(const std::string &label, double pressure, double resistance);

  /// u = 0, p = p0 on the mesh moved by `ale_displacement` (three components a node), which is taken as the old one as
  /// well.
  void start(const fem::Vector &ale_displacement);
  /// The old states and the old motion, to be saved or loaded at the owned nodes. Orifices are open or closed as they
  /// were in the step that led here.
  void visit(io::State &state);
  /// After loading: as if the old state had just been committed.
  void resume();
  /// The next solve makes it anew, and guesses without what iterates have moved.
  void forget_preconditioner();
  /// Moves the mesh to d^{n+1} and assembles the step's matrix. Orifices may have been opened or closed before.
  void prepare(const fem::Vector &ale_displacement);
  /// Solves with the wall's velocity v* and force W*; any number of times from the same old state. `iteration` 0 starts
  /// from the extrapolated old states, the others from the last solution of the step, and what they moved in the steps
  /// before.
  fem::LinearStatistics solve(const fem::Vector &wall_velocity, const fem::Vector &wall_force, int iteration = 0);
  /// The solve of this iteration takes its datum from Anderson's method.
  void accelerate(const fem::Vector &wall_velocity, const fem::Vector &wall_force, int iteration);
  /// Raises the pressure everywhere, and the force on the wall with it.
  void add_pressure(double pressure);
  /// The new state becomes the old one.
  void commit();

  const fem::Vector &state() const { return x_; }           ///< u, v, w, p / pressure_scale; ghosts valid
  const fem::Vector &blood_force() const { return force_; } ///< L, zero off the interface and where u is prescribed
  const fem::Vector &ale_displacement() const { return d_np1_; }
  double pressure_scale() const { return pressure_scale_; }
  const fem::LagrangeSpace &space() const { return space_; }
  bus::Stopwatch stopwatch;
  const fem::BlockMatrix<float> &matrix() const { return A_; } ///< of the prepared step
  const fem::Constraints &constraints() const { return constrained_; }

  // For those who solve more than the fluid: the step is a linear system A (x - guess) = -residual(guess) in between.
  const fem::Vector &guess() const { return guess_; }
  const std::vector<bool> &open_orifices() const { return orifices_open_; }
  /// r = all terms but the wall's at the state x.
  void residual(const fem::Vector &x, fem::Vector &r) const;
  /// y = A x, with the resistances of open orifices.
  void apply(fem::Vector &y, const fem::Vector &x) const;
  /// Of the kind the parameters ask for.
  std::unique_ptr<fem::Preconditioner> make_preconditioner(const fem::BlockMatrix<double> &matrix) const;
  /// Takes a state that somebody else has found, with the force on the wall.
  void accept(const fem::Vector &x, const fem::Vector &blood_force);

  /// b.u = int_S u.n over the interface: the nodal forces of a unit pressure.
  fem::Vector unit_pressure_force() const;
  /// What the new state leaves of the interface's conditions, with the wall's new velocity (ghosts not needed).
  interface::Budget budget(const fem::Vector &wall_velocity);
  /// Through an open orifice, of the latest solution; one sum over the ranks.
  Inflow inflow(const Orifice &orifice) const;
  double volume() const { return volume_; }               ///< of the moved fluid domain [m^3]
  double mean_pressure() const { return mean_pressure_; } ///< over the moved domain, of the latest solution [Pa]
  /// -a_f(u, p; w) of the new state, evaluated afresh: on interface test functions it must equal blood_force().
  fem::Vector reaction() const;

  /// For manufactured solutions: velocities of nodes where they are prescribed (else zero), and a force per volume at
  /// points of the moved mesh. Both count from the next `prepare`.
  fem::Vector boundary_values;
  std::function<geometry::Point3(const geometry::Point3 &)> body_force;
  fem::Vector &old_state() { return past_[0]; }

 private:
  void move(const fem::Vector &ale_displacement);
  void set_interface_velocity();
  void set_reaction_force();
  void update_constraints();
  void set_guess();
  void assemble();
  void integrate_cells(const fem::Vector &state, fem::BlockMatrix<float> *A, fem::Vector &residual) const;
  void add_surface_terms();
  void refresh_preconditioner();
  interface::RobinCondition::Surface robin_surface() const;
  void update_averages();
  template <class Action>
  void visit_batches(const fem::Vector &state, const Action &action) const;

  const fem::LagrangeSpace &space_;
  Parameters parameters_;
  double dt_, pressure_scale_, inertia_ = 1;
  interface::RobinCondition robin_;
  bool has_datum_ = false; // of the next solve
  std::vector<double> unit_nodes_;
  std::optional<MovedSurface> interface_;
  std::vector<double> interface_masses_; // of alpha |n da|
  double interface_area_ = 0;            // of this rank's cells
  fem::Vector interface_flux_;           // interface_flux_ * u = int u.n
  std::vector<std::unique_ptr<Orifice>> orifices_;
  std::vector<bool> orifices_open_;                 ///< for which the constraints stand
  fem::Constraints constrained_, held_by_the_wall_; ///< empty on a rank without nodes
  bool constraints_are_known_ = false, follows_motion_ = false;
  fem::BlockMatrix<float> A_;
  std::unique_ptr<fem::Preconditioner> preconditioner_;
  fem::PreconditionerAge preconditioner_age_{2};

  fem::TimeHistory past_;                                        // states at t^n, t^{n-1}, t^{n-2}
  fem::Vector x_;                                                // the new state
  bool history_is_new_ = true;                                   // since the last commit: there is no third state yet
  fem::Vector d_n_, d_np1_;                                      // motions of the mesh
  fem::Vector guess_, increment_;                                // x = guess + increment
  fem::IterateExtrapolation<fem::Vector> iterate_extrapolation_; // of the increment
  fem::Vector residual_;                                         // of the guess, all terms but the wall's
  fem::Vector guess_load_;                                       // A guess
  fem::Vector force_;                                            // L
  double volume_ = 0, mean_pressure_ = 0;
};

} // namespace heartbus::fluid
