#pragma once

#include "ale_solver/lifting_problem.h"
#include "common/bus/solver.h"
#include "common/fem/time_history.h"
#include "common/io/state.h"

#include <vector>

namespace heartbus::ale {

/// Motion of the fluid's mesh (paper, section 2.4 and 3.1, step 3): lifts the wall's displacement. The history serves
/// nothing but the linear solver's first guess.
class ALESolver : public bus::Solver {
 public:
  ALESolver(const fem::LagrangeSpace &space, const Parameters &parameters);

  void declare(bus::Declaration &declaration) override;
  void prepare_step(const bus::Step &) override;
  void solve_step(const bus::Step &) override;
  void commit_step(const bus::Step &) override;
  void save_state(const std::string &folder, const bus::Step &) override;
  void load_state(const std::string &folder, const bus::Step &) override;
  std::vector<bus::Stopwatch *> stopwatches() override { return {&problem_.stopwatch}; }

 private:
  void visit(io::State &state);
  void require_displacement();

  const fem::LagrangeSpace &space_;
  LiftingProblem problem_;
  fem::Vector ale_displacement_;
  fem::TimeHistory past_; ///< motions
  bool has_history_ = false, has_displacement_ = false;
  std::vector<unsigned> interface_nodes_;          ///< owned
  std::vector<double> displacement_, mesh_motion_; ///< what the bus fills and reads
  unsigned iterations_ = 0;
};

} // namespace heartbus::ale
