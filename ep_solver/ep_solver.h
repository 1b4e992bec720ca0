#pragma once

#include "common/bus/solver.h"
#include "common/io/field_writer.h"
#include "common/io/state.h"
#include "common/schema/scene.h"
#include "ep_solver/ionic/ionic_model.h"
#include "ep_solver/monodomain_problem.h"
#include "ep_solver/stimulus.h"

namespace heartbus::ep {

/// Electrophysiology (paper, section 2.2): potential v and ionic states at the nodes of the refined solid mesh,
/// advanced by the scheme of section 3.1, step 1: ionic model, then monodomain equation. Sends calcium^{n+1}.
class EPSolver : public bus::Solver {
 public:
  /// `D`: conductivity [m^2/s] at the quadrature points, [batch * n_q + q].
  EPSolver(const fem::LagrangeSpace &space, const std::vector<fem::Mat3<fem::Lanes>> &D, const Parameters &parameters);
  /// Writes potential and calcium when they are due, the activation map in the end.
  void write_fields(const std::string &folder, const OutputParameters &output);

  void declare(bus::Declaration &declaration) override;
  void prepare_step(const bus::Step &step) override;
  void solve_step(const bus::Step &step) override;
  void commit_step(const bus::Step &step) override;
  void save_state(const std::string &folder, const bus::Step &step) override;
  void load_state(const std::string &folder, const bus::Step &step) override;
  std::vector<bus::Stopwatch *> stopwatches() override { return {&problem_.stopwatch}; }
  void finish() override;

  const fem::Vector &potential() const { return n_.v; }           ///< [V]
  const std::vector<double> &calcium() const { return calcium_; } ///< [uM], owned nodes
  const std::vector<double> &activation_times() const {
    return n_.activation;
  } ///< [s] since the beat's beginning, owned nodes; NaN: not yet
  /// The latest activation of this rank's nodes in this beat [s]; NaN until all of them are active.
  double last_activation() const;
  double n_activated() const;                         ///< of this rank's nodes, in this beat
  unsigned iterations() const { return iterations_; } ///< of the linear solver in the last step, all substeps

 private:
  struct State {
    fem::Vector v, v_before; ///< at the end of the step and one (sub)step before it
    std::vector<fem::Lanes> ionic;
    std::vector<double> activation;
  };
  void advance(double time, double dt, const std::vector<fem::Lanes> &ionic_n, State &state);
  void visit(io::State &state); ///< what is at the end of the last step
  void write(double time);

  const fem::LagrangeSpace &space_;
  double period_, beat_begin_ = 0; ///< of the stimulus, which begins a beat [s]
  int substeps_;
  std::unique_ptr<IonicModel> model_;
  Stimulus stimulus_;
  MonodomainProblem problem_;
  State n_, np1_;
  fem::Vector current_;
  std::vector<double> calcium_;
  unsigned iterations_ = 0;
  OutputParameters output_;
  std::string folder_;
  std::unique_ptr<io::FieldWriter> writer_;
};

} // namespace heartbus::ep
