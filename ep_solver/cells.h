#pragma once

#include "ep_solver/ionic/ionic_model.h"

namespace heartbus::ep {

/// The cells at all nodes over a step that is divided into substeps, by a multirate scheme (Gear, Wells, BIT 24 (1984)
/// 484, doi:10.1007/BF01934907). Where a front passes, cells take every substep: these are the fast ones. The others
/// are slow: they take the step at once, with the potential extrapolated to its middle, and their I_ion holds for all
/// substeps.
///
/// What tells them apart is curvature, the difference from extrapolation over the square of the time that was
/// extrapolated [1/s^2]: over a step of length dt a cell misses about curvature * dt^2.
class Cells {
 public:
  Cells(const IonicModel &model, Integrator integrator, unsigned n_nodes);

  /// `v` is the potential [V] that the integrator asks for (ionic_model.h) of the step of length `step` [s]. Cells of
  /// nodes with is_fast[node] wait for their substeps.
  void begin_step(const std::vector<fem::VectorizedDouble> &states_n, const double *v, double step,
                  const std::vector<char> &is_fast);
  /// `v` as above, of the substep. Sets I_ion [V/s] of all nodes.
  void substep(const double *v, double dt, double *I_ion);
  void end_step(std::vector<fem::VectorizedDouble> &states_np1) const;

  const std::vector<double> &curvature() const { return curvature_; } ///< in the step so far, [node]

 private:
  const IonicModel &model_;
  Integrator integrator_;
  std::vector<unsigned> fast_; ///< nodes
  std::vector<fem::VectorizedDouble> states_, fast_states_;
  std::vector<double> I_ion_, curvature_, error_; ///< [node]
  std::vector<double> fast_v_, fast_I_ion_;       ///< [fast node]
};

} // namespace heartbus::ep
