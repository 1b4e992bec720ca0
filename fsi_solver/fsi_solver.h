#pragma once

#include "fluid_solver/fluid_solver.h"
#include "fsi_solver/fsi_problem.h"
#include "mech_solver/mech_solver.h"

namespace heartbus::fsi {

/// Blood and wall as one participant (paper, section 3.2): all that surrounds the solve, from force generation
/// to valves and pictures, is done by the two solvers that each of them has alone; only the solve is the merged one.
/// Takes calcium and the mesh motion, gives the displacement.
class FsiSolver : public bus::Solver {
 public:
  /// Both are meant to be told nothing of the interface.
  FsiSolver(mech::MechSolver &mech, fluid::FluidSolver &fluid, double dt);

  void declare(bus::Declaration &declaration) override;
  void prepare_step(const bus::Step &step) override;
  void solve_step(const bus::Step &step) override;
  void commit_step(const bus::Step &step) override;
  /// The states of blood and wall are those that they have apart: either goes on from the other's.
  void save_state(const std::string &folder, const bus::Step &step) override;
  void load_state(const std::string &folder, const bus::Step &step) override;
  void refresh() override;
  std::vector<bus::Stopwatch *> stopwatches() override;

 private:
  void budget(const fem::Vector &d, double dt);

  mech::MechSolver &mech_;
  fluid::FluidSolver &fluid_;
  FsiProblem problem_;
  fem::NewtonStatistics statistics_;
};

} // namespace heartbus::fsi
