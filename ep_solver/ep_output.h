#pragma once

#include "common/bus/solver.h"
#include "common/fem/lagrange_space.h"
#include "common/io/field_writer.h"
#include "common/settings/output.h"

namespace heartbus::ep {

/// What electrophysiology writes, whoever computes it: potential and calcium when they are due, the maps of activation
/// and repolarisation in the end. All values at owned nodes. Collective.
class EPOutput {
 public:
  explicit EPOutput(const fem::LagrangeSpace &space) : space_(space) {}
  /// Without it nothing is written.
  void write_to(const std::string &folder, const OutputParameters &output);
  void go_on_from(double time);
  bool writes_start(const bus::Step &step) const { return writer_ && step.number == 1; }
  bool is_due(const bus::Step &step) const { return writer_ && output_.due(step.number, step.size); }
  void write(double time, const double *potential, const double *calcium);
  void write_maps(const double *activation, const double *repolarisation);

 private:
  const fem::LagrangeSpace &space_;
  OutputParameters output_;
  std::string folder_;
  std::unique_ptr<io::FieldWriter> writer_;
};

/// The latest of times of activation [s] that are not after `now`; NaN while a node is not active.
double last_activation(const std::vector<double> &activation, double now);
/// How many there are until `now`.
double n_activated(const std::vector<double> &activation, double now);
/// Scalars `activation_time` and `activated_share`. Collective.
void declare_activation(bus::Declaration &declaration, const fem::LagrangeSpace &space,
                        const std::vector<double> &activation, const double &now);

} // namespace heartbus::ep
