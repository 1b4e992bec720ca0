#pragma once

#include <string>
#include <vector>

namespace heartbus::io {

/// All that a physics must remember to go on as if it had never stopped: nodal fields, keyed by the reference
/// coordinates of their points and therefore independent of partition and ranks, and named numbers. One function of the
/// physics shows them, to be saved or to be loaded, so that both always agree:
///
///     void visit(io::State &state) {
///       state.points("tissue", coordinates, spacing);
///       state.field("displacement", 3, d.begin());
///       state.number("step_size", dt);
///     }
class State {
 public:
  virtual ~State() = default;
  /// The points of the fields that follow: those this rank owns, three coordinates each [m]. `spacing` is the distance
  /// between neighbours [m].
  virtual void points(const std::string &name, const std::vector<double> &coordinates, double spacing) = 0;
  /// `components` interleaved values a point.
  virtual void field(const std::string &name, unsigned components, double *values) = 0;
  /// NaN where there is no value yet. All other fields must be finite: what is not is neither saved nor loaded,
  /// Failure(not_finite).
  virtual void partial_field(const std::string &name, unsigned components, double *values) = 0;
  /// The same on all ranks.
  virtual void number(const std::string &name, double &value) = 0;
};

} // namespace heartbus::io
