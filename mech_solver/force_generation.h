#pragma once

#include "common/io/state.h"
#include "mech_solver/active/active_model.h"
#include "mech_solver/settings/parameters.h"

#include <memory>
#include <vector>

namespace heartbus::mech {

/// Force generation at the owned nodes (paper, section 2.3 and 3.1, step 2): s^{n+1} from s^n, calcium^{n+1} and the
/// fibre stretch of d^n, sarcomere length SL = SL0 sqrt(I4f); then T = tension_max G(s). With model "none", T = 0; with
/// "prescribed", T is the scene's at the end of the step.
class ForceGeneration {
 public:
  ForceGeneration(const ActiveParameters &parameters, unsigned n_nodes);
  /// Nodes with negative calcium have not been told any and keep their state. May be repeated: starts from s^n.
  void advance(double dt, const double *calcium, const double *stretch);
  /// At how many nodes the last advance met a sarcomere length that the model clamps.
  unsigned n_clamped() const { return n_clamped_; }
  void commit() { s_n_ = s_; }
  /// s^n, to be saved or loaded.
  void visit(io::State &state);
  /// T(s^{n+1}) or T(s^n), [node] [Pa]; `time` is t^{n+1} or t^n.
  void tension(double time, double *values) const { tension(s_, time, values); }
  void old_tension(double time, double *values) const { tension(s_n_, time, values); }

 private:
  void tension(const std::vector<double> &states, double time, double *values) const;
  ActiveParameters parameters_;
  std::unique_ptr<ActiveModel> model_; ///< null: none
  unsigned n_nodes_, n_states_ = 0, n_clamped_ = 0;
  std::vector<double> s_n_, s_; ///< [node][state]
};

} // namespace heartbus::mech
