#pragma once

#include "common/bus/solver.h"
#include "common/interface/nodal/blood_side.h"
#include "common/io/field_writer.h"
#include "common/io/state.h"
#include "common/settings/output.h"
#include "fluid_solver/models/inflow_watch.h"
#include "fluid_solver/models/valves.h"
#include "fluid_solver/navier_stokes_problem.h"

#include <memory>
#include <optional>
#include <spdlog/logger.h>
#include <string>
#include <vector>

namespace heartbus::fluid {

/// The blood (paper, section 2.5 and 3.1, step 4): velocity and pressure on the moving mesh, valves, and a condition on
/// the interface. Takes the mesh motion and, for the Robin condition, the wall's velocity v* and force W*; returns the
/// force L on the wall.
class FluidSolver : public bus::Solver {
 public:
  /// Valves are there when the mesh has boundaries `mitral` and `aortic`.
  FluidSolver(const fem::LagrangeSpace &space, const Parameters &parameters, const interface::BloodSettings &settings,
              double dt, std::shared_ptr<spdlog::logger> log);
  /// Writes velocity, pressure and mesh motion when they are due.
  void write_fields(const std::string &folder, const OutputParameters &output);

  void declare(bus::Declaration &declaration) override;
  void prepare_step(const bus::Step &step) override;
  void solve_step(const bus::Step &step) override;
  void commit_step(const bus::Step &step) override;
  void save_state(const std::string &folder, const bus::Step &step) override;
  void load_state(const std::string &folder, const bus::Step &step) override;
  void refresh() override { problem_.forget_preconditioner(); }
  std::vector<bus::Stopwatch *> stopwatches() override { return {&problem_.stopwatch}; }

  const NavierStokesProblem &problem() const { return problem_; }
  NavierStokesProblem &problem() { return problem_; } ///< for those who solve blood and wall together
  const std::optional<Valves> &valves() const { return valves_; }
  /// Compares the new velocity with the wall's new velocity (zero off the interface).
  void budget(const fem::Vector &wall_velocity);

 private:
  /// An empty history: the mesh as it comes, blood at rest.
  void start();
  void declare_tasks(bus::Declaration &declaration); ///< of the Robin condition
  /// The velocity with which blood at rest yields to a force on the wall, u = -F^{-1} L: a_f(u, p; w) = -L(w) without
  /// Robin term and other loads, in the cavity as it is, valves included. Which F:
  /// common/interface/nodal/alpha_limit.h.
  void begin_probe();
  void probe();
  bool isovolumetric() const;
  fem::Vector ale_displacement() const;
  void refuse_instability(const bus::Step &step);
  void refuse_runaway_inflow(const bus::Step &step, const Orifice &orifice, bool is_lost);
  void watch_inflow(const bus::Step &step);
  void require_opening() const;
  void switch_valves(double time);
  void show_valves();
  void prepare_aorta(); ///< to the problem
  AtOrifice at(const Orifice &orifice, double direction) const;
  void visit(io::State &state);
  fem::Vector shown_motion() const;
  void write(double time);

  const fem::LagrangeSpace &space_;
  Parameters parameters_;
  std::shared_ptr<spdlog::logger> log_;
  NavierStokesProblem problem_;
  double dt_;
  std::optional<Valves> valves_;
  Orifice *mitral_ = nullptr, *aortic_ = nullptr, *inlet_ = nullptr;
  AtOrifice at_mitral_, at_aortic_;

  interface::BloodSide side_;
  std::vector<double> mesh_motion_; ///< of the bus
  fem::LinearStatistics statistics_;
  interface::Budget budget_;
  fem::Vector wall_velocity_;                          ///< of the last budget, for output; empty before
  std::unique_ptr<NavierStokesProblem> blood_at_rest_; ///< to be probed
  InflowWatch inflow_watch_;                           ///< of the mitral valve, or the inlet
  int coupling_iterations_ = 0;                        ///< of the last step

  double arterial_pressure_n_;        ///< p^n of the arteries [Pa]
  Windkessel::Answer arteries_{0, 0}; ///< in this step
  OutputParameters output_;
  std::unique_ptr<io::FieldWriter> writer_;
};

} // namespace heartbus::fluid
