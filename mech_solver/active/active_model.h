#pragma once

#include <memory>
#include <string>
#include <vector>

namespace heartbus::mech {

/// A model of active force generation: a small system of ordinary differential equations at each point,
///
///     ds/dt = f(s, calcium, sarcomere length),   permissivity G(s) in [0, 1],   tension T = T_max G(s).
///
/// To add one: a header and a source in this folder, a test in tests/unit, a line in force_models.h.
class ActiveModel {
 public:
  virtual ~ActiveModel() = default;
  virtual unsigned n_states() const = 0;
  /// The resting state, `n_states` numbers.
  virtual std::vector<double> initial_state() const = 0;
  /// f(s), for tests and for those who bring their own integrator; calcium [uM], sarcomere length [um], result [1/s].
  virtual void rate(const double *s, double calcium, double sarcomere_length, double *ds) const = 0;
  /// One step of the model's own integrator at one point.
  virtual void advance(double dt, double calcium, double sarcomere_length, double *s) const = 0;
  virtual double permissivity(const double *s) const = 0;
  /// Whether the model takes another sarcomere length [um] in place of this one, which it does not know.
  virtual bool clamps(double sarcomere_length) const = 0;
};

/// `name` is one of force_models.h; Failure(scene) otherwise.
std::unique_ptr<ActiveModel> make_active_model(const std::string &name);

} // namespace heartbus::mech
