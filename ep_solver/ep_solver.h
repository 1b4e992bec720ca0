#pragma once

#include "common/io/state.h"
#include "ep_solver/cells.h"
#include "ep_solver/ep_output.h"
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
///
/// A step of electrophysiology may reach over several steps of the coupling (substeps.h). Within it, what is sent and
/// written lies on the line between its ends.
class EPSolver : public bus::Solver {
 public:
  /// `D`: conductivity [m^2/s] at the quadrature points, [batch * n_q + q].
  EPSolver(const fem::LagrangeSpace &space, const std::vector<fem::Mat3<fem::VectorizedDouble>> &D,
           const Parameters &parameters);
  void write_fields(const std::string &folder, const OutputParameters &output) { output_.write_to(folder, output); }
  /// Makes the matrices that the first step needs, of a whole step and of its halves, now rather than then.
  void expect_steps_of(double size) {
    for (const int substeps : {1, 2})
      problem_.set_step(implicit_share() * size / substeps);
  }

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
  double last_activation() const { return ep::last_activation(n_.activation, now_); }
  unsigned iterations() const { return iterations_; } ///< of the linear solver in the last step, all substeps
  /// Of the last step; 0: it lies within one that was computed before.
  unsigned substeps() const { return substeps_; }
  double end() const { return n_.end; } ///< how far electrophysiology has come [s]

 private:
  struct State {
    double begin = 0, end = 0; ///< of the last step of electrophysiology [s]
    fem::Vector v, v_before;   ///< at its end and one substep before it
    fem::Vector current;       ///< I_app - I_ion of that substep
    double dt_before = 1e-6;   ///< length of that substep [s]; at the start, where nothing changes, next to nothing
    double longest = 1;        ///< substep that the next step starts with, at most [s]
    std::vector<fem::VectorizedDouble> ionic;
    std::vector<double> calcium_begin;              ///< [uM], at its begin
    std::vector<double> curvature;                  ///< within it (cells.h) [1/s^2]
    std::vector<double> activation, repolarisation; ///< of this beat, from its begin [s]; NaN: not yet
    void swap(State &other);
    double share(double time) const; ///< of the last step that has passed at this time
  };
  struct Estimate { ///< the largest of all ranks
    double of_all;  ///< of a substep, whether a cell took it or not
    double of_slow; ///< of the step, for those that took it at once
  };
  /// Where in a substep diffusion is taken implicitly, as a share of it: in the middle or at the end.
  double implicit_share() const { return integrator_ == Integrator::exponential_midpoint ? 0.5 : 1; }
  void advance_to(const bus::Step &step);
  void begin_advance(double end);
  Estimate advance(Division division, double length);
  Estimate estimate(Division division, double length);
  const double *extrapolate(double length);
  void take_substep(double end, double dt);
  void finish_substep(double end, double dt);
  void set_calcium(const State &state, double time);
  void visit(io::State &state); ///< what is at the end of the last step
  void write(double time);

  const fem::LagrangeSpace &space_;
  double period_, beat_begin_ = 0; ///< of the stimulus, which begins a beat [s]
  SubstepControl control_;
  Integrator integrator_;
  std::unique_ptr<IonicModel> model_;
  Cells cells_;
  Stimulus stimulus_;
  MonodomainProblem problem_;
  State n_, np1_;
  bool ahead_ = false;           ///< the step lies within the last one of electrophysiology
  double now_ = 0;               ///< end of the last step of the coupling, from the beat's begin [s]
  fem::Vector current_, solved_; ///< solved_: v^{n+1}, or v in the middle of the substep
  std::vector<char> is_fast_;    ///< [node]
  std::vector<double> calcium_;
  unsigned iterations_ = 0, substeps_ = 0;
  EPOutput output_;
};

} // namespace heartbus::ep
