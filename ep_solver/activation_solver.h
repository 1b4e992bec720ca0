#pragma once

#include "ep_solver/ep_output.h"
#include "ep_solver/ionic/transient.h"
#include "ep_solver/settings/parameters.h"

namespace heartbus::ep {

/// Electrophysiology of a wall whose times of activation are known: each node passes through the potential and
/// calcium of a paced cell from then on, or through a prescribed transient of calcium,
///
///     v(x, t) = v_cell(t - T(x)),   calcium(x, t) = calcium_cell(t - T(x)),
///
/// periodic with the stimulus: before its first activation a node is late in the beat before. It stores nothing that a
/// run would need to go on.
class ActivationSolver : public bus::Solver {
 public:
  /// `activation`: of owned nodes, since the beginning of a beat [s]; NaN: never, at rest.
  ActivationSolver(const fem::LagrangeSpace &space, std::vector<double> activation, const IonicModel &model,
                   const Parameters &parameters);
  void write_fields(const std::string &folder, const OutputParameters &output) { output_.write_to(folder, output); }

  void declare(bus::Declaration &declaration) override;
  void prepare_step(const bus::Step &step) override;
  void solve_step(const bus::Step &step) override;
  void commit_step(const bus::Step &step) override;
  void load_state(const std::string &folder, const bus::Step &step) override;
  void finish() override;

  const std::vector<double> &activation_times() const { return activation_; } ///< [s], owned nodes
  const std::vector<double> &calcium() const { return calcium_; }             ///< [uM], owned nodes

 private:
  double calcium_at(double phase) const;
  void set_calcium(double time);
  void write(double time);

  const fem::LagrangeSpace &space_;
  const double period_; ///< [s]
  const Transient transient_;
  const PrescribedParameters prescribed_;
  const std::vector<double> activation_;
  std::vector<double> calcium_;
  double now_ = 0; ///< end of the last step, from the beat's begin [s]
  EPOutput output_;
};

} // namespace heartbus::ep
