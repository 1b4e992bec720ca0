#pragma once

#include "common/bus/solver.h"
#include "common/io/field_writer.h"
#include "common/io/state.h"
#include "common/schema/scene.h"
#include "ep_solver/ionic/ionic_model.h"
#include "ep_solver/monodomain_problem.h"
#include "ep_solver/stimulus.h"
#include "ep_solver/substeps.h"

namespace heartbus::ep {

/// Electrophysiology (paper, section 2.2): potential v and ionic states at the nodes of the refined solid mesh,
/// advanced by ionic model, then monodomain equation, and sends calcium^{n+1}. Either by the scheme of section 3.1,
/// step 1, of first order, or with both at the middle of the (sub)step, of second: the ionic model gives I_ion^{n+1/2}
/// from the extrapolated potential, then (ionic_model.h, monodomain_problem.h)
///
///     (2 M/dt + K) v^{n+1/2} = M (2 v^n/dt - I_ion^{n+1/2} + I_app),   v^{n+1} = 2 v^{n+1/2} - v^n.
class EPSolver : public bus::Solver {
 public:
  /// `D`: conductivity [m^2/s] at the quadrature points, [batch * n_q + q].
  EPSolver(const fem::LagrangeSpace &space, const std::vector<fem::Mat3<fem::Lanes>> &D, const Parameters &parameters);
  /// Writes potential and calcium when they are due, the maps of activation and repolarisation in the end.
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
  /// Since the beat's beginning [s], owned nodes; NaN: not yet.
  const std::vector<double> &activation_times() const { return n_.activation; }
  /// The latest activation of this rank's nodes in this beat [s]; NaN until all of them are active.
  double last_activation() const;
  double n_activated() const;                         ///< of this rank's nodes, in this beat
  unsigned iterations() const { return iterations_; } ///< of the linear solver in the last step, all substeps
  unsigned substeps() const { return substeps_; }     ///< of the last step

 private:
  struct State {
    fem::Vector v, v_before; ///< at the end of the step and one substep before it
    double dt_before = 1;    ///< length of that substep [s]
    double longest = 1;      ///< substep that the next step of the coupling starts with, at most [s]
    std::vector<fem::Lanes> ionic;
    std::vector<double> activation, repolarisation; ///< of this beat, from its begin [s]; NaN: not yet
  };
  double advance_by(int n_substeps, const bus::Step &step);
  double advance(double end, double dt, const std::vector<fem::Lanes> &ionic_n, State &state);
  double finish_substep(double end, double dt, State &state);
  void visit(io::State &state); ///< what is at the end of the last step
  void write(double time);

  const fem::LagrangeSpace &space_;
  double period_, beat_begin_ = 0; ///< of the stimulus, which begins a beat [s]
  SubstepControl control_;
  Integrator integrator_;
  std::unique_ptr<IonicModel> model_;
  Stimulus stimulus_;
  MonodomainProblem problem_;
  State n_, np1_;
  fem::Vector current_, solved_; ///< solved_: v^{n+1}, or v in the middle of the substep
  std::vector<double> calcium_;
  unsigned iterations_ = 0, substeps_ = 0;
  OutputParameters output_;
  std::string folder_;
  std::unique_ptr<io::FieldWriter> writer_;
};

} // namespace heartbus::ep
