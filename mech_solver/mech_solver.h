#pragma once

#include "common/bus/solver.h"
#include "common/interface/nodal/pressure_correction.h"
#include "common/interface/nodal/wall_probe.h"
#include "common/io/field_writer.h"
#include "common/io/state.h"
#include "common/nonlinear/iterate_extrapolation.h"
#include "common/settings/output.h"
#include "mech_solver/cavity_filling.h"
#include "mech_solver/elasticity_problem.h"
#include "mech_solver/force_generation.h"
#include "mech_solver/interface_wall.h"

#include <functional>
#include <memory>
#include <optional>
#include <spdlog/logger.h>
#include <string>
#include <vector>

namespace heartbus::mech {

/// The heart muscle (paper, sections 2.3 and 2.4; 3.1, steps 2 and 5): active tension from calcium, displacement from
/// the blood's force, and the Robin datum for the blood. All forces are nodal forces on the solid [N]; with L the blood
/// force and R_s the residual of the solid on interface nodes, R_s(d^{n+1}, s^{n+1}) = L. The datum of iteration k is
///
///     k = 0:   v* = (d^n - d^{n-1})/dt,
///              W* = R_s(d^n, s^{n+1}) = L^n + int (P_act(d^n, s^{n+1}) - P_act(d^n, s^n)) : grad phi
///     k >= 1:  v* = (d_(k) - d^n)/dt,
///              W* = L_(k)
///
/// (the paper prints (d_(k) - d^{n-1})/dt for k >= 1, which has a wrong fixed point). Forces at held degrees of freedom
/// are zero.
class MechSolver : public bus::Solver {
 public:
  MechSolver(const fem::LagrangeSpace &space, const fem::Fibres &fibres, const Parameters &parameters,
             std::shared_ptr<spdlog::logger> log);
  /// Writes displacement, tension, stretch and fibres when they are due.
  void write_fields(const std::string &folder, const OutputParameters &output);

  /// What loads the interface; without it the blood's force does. Before `declare`.
  void couple(const interface::WallSettings &settings);

  void declare(bus::Declaration &declaration) override;
  /// s^{n+1}; then v* and W* of k = 0.
  void prepare_step(const bus::Step &step) override;
  /// d^{n+1}; then v* and W* for the next iteration.
  void solve_step(const bus::Step &step) override;
  void commit_step(const bus::Step &step) override;
  void save_state(const std::string &folder, const bus::Step &step) override;
  void load_state(const std::string &folder, const bus::Step &step) override;
  void refresh() override;
  std::vector<bus::Stopwatch *> stopwatches() override { return {&problem_.stopwatch}; }
  /// Quasi-static d^0 under the initial pressure and the tension at rest, d^{-1} = d^0, L^0 = R_s(d^0, s^0).
  void inflate();
  /// One pressure that makes up for the step's volume defect (common/interface/nodal/pressure_correction.h).
  void correct(const bus::Step &step);
  /// Moves the wall to where the circulation's pressure has it.
  void press(const bus::Step &step);

  // For those who solve the wall together with something else, solve_step in two parts: the displacement to start from,
  // which they overwrite with d^{n+1}, and what follows from it.
  fem::Vector &begin_solve(const bus::Step &step);
  void end_solve(const bus::Step &step, const fem::NewtonStatistics &statistics);
  ElasticityProblem &problem() { return problem_; }
  /// L^{n+1}, for who goes on from here with wall and blood apart. Before end_solve.
  void set_blood_force(const fem::Vector &forces) { interface_.get(forces, blood_force_); }

 private:
  void declare_shares(bus::Declaration &bus);
  void declare_probes(bus::Declaration &bus);
  void find_probes();
  void measure_cavity();
  void visit(io::State &state, const bus::Step &step); ///< d^n, d^{n-1}, s^n, L^n
  /// Equilibrium under loads that `load` makes grow from what they were (share 0) to what they shall be (1): in so many
  /// steps, and where Newton's method does not bear one, in halves of it.
  void equilibrate(int steps, const std::function<void(double share)> &load);
  void find_equilibrium(const bus::Step &step);
  void choose_start(const bus::Step &step);
  void show_motion(double dt); ///< to the bus: displacement and velocity of d
  double peak_tension() const; ///< of this rank's nodes
  void refuse_calcium_that_is_not_finite() const;
  void write(double time);

  const fem::LagrangeSpace &space_;
  const fem::Fibres &fibres_;
  Parameters parameters_;
  std::shared_ptr<spdlog::logger> log_;
  ElasticityProblem problem_;
  ForceGeneration force_generation_;
  fem::Vector d_, stretch_;
  fem::IterateExtrapolation<fem::Vector> iterate_extrapolation_;

  interface::InterfaceNodes interface_;
  // what the bus reads and fills; calcium is negative until it arrives
  std::vector<double> calcium_, blood_force_, displacement_, wall_velocity_, wall_force_;
  std::vector<double> blood_force_n_;
  std::vector<double> held_; ///< 1 at degrees of freedom of the interface that do not move, else 0
  fem::NewtonStatistics statistics_;
  bool is_alone_ = false;
  std::vector<LoadedSurface> cavity_; ///< the interface, or nothing
  double own_cavity_volume_ = 0;      ///< [m^3]
  std::map<std::string, int> probes_; ///< the node, or -1 on other ranks

  interface::WallProbe probe_;                          ///< of the limit of alpha
  std::optional<InterfaceWall> linear_wall_;            ///< when blood in another participant pushes
  std::optional<interface::WallCorrection> correction_; ///< likewise
  PressureResponse response_;
  std::optional<CavityFilling> filling_; ///< when a circulation takes part

  OutputParameters output_;
  std::unique_ptr<io::FieldWriter> writer_;
};

} // namespace heartbus::mech
