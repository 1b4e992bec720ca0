#pragma once

#include "cavity_solver/circulation.h"

#include "common/bus/solver.h"
#include "common/io/state.h"

#include <mpi.h>
#include <vector>

namespace heartbus::cavity {

/// The blood of the ventricle as one pressure (0D), in place of Navier-Stokes in three dimensions: no mesh, one rank.
/// It counts the blood by what flows, so that what the wall's motion misses in a step is made up for in the next.
class CavitySolver : public bus::Solver {
 public:
  CavitySolver(MPI_Comm communicator, const CirculationParameters &parameters, double initial_pressure);
  void declare(bus::Declaration &declaration) override;
  void prepare_step(const bus::Step &) override {}
  void solve_step(const bus::Step &step) override;
  void commit_step(const bus::Step &step) override;
  void save_state(const std::string &folder, const bus::Step &step) override;
  void load_state(const std::string &folder, const bus::Step &step) override;

 private:
  void visit(io::State &state);
  int phase() const;

  MPI_Comm communicator_;
  Circulation circulation_;
  double old_volume_ = 0, blood_volume_ = 0; ///< [m^3]
  double last_phase_ = 0;                    ///< of those with an open valve or none yet
  std::vector<double> volume_ = {0}, compliance_ = {0}, guess_ = {0}, pressure_; ///< of the bus
};

} // namespace heartbus::cavity
