#pragma once

#include "common/base/stopwatch.h"

#include <functional>
#include <string>
#include <vector>

namespace heartbus::bus {

/// Where the run stands: step n -> n+1.
struct Step {
  int number = 0;    ///< of the step being computed, 1-based; 0 in the start block
  int iteration = 0; ///< of the coupling loop within the step, 0-based
  double time = 0;   ///< t^{n+1} [s]
  double size = 0;   ///< dt = t^{n+1} - t^n [s]
};

/// How the values that the ranks have of a scalar become one: that of rank 0, the extreme one (NaN if one is NaN), or
/// their sum.
enum class Combine { first, min, max, sum };

/// What a participant tells the coupler about itself before the run. All data are held by the solver; the bus reads
/// `output` buffers when a transfer is ordered and fills `input` buffers before the next command is executed.
class Declaration {
 public:
  virtual ~Declaration() = default;

  /// Points this rank owns, three coordinates each [m], reference configuration, in the order of the field values.
  /// `spacing` is the characteristic distance between neighbours [m], to which the matching tolerance is relative.
  virtual void point_set(const std::string &name, const std::vector<double> &coordinates, double spacing) = 0;

  /// Faces between points of this set that this rank owns, by the places of their corners: 3 * n_corners numbers a face
  /// [m]. For participants that have no mesh of their own.
  virtual void faces(const std::string &point_set, unsigned n_corners, const std::vector<double> &corners) = 0;

  /// In place of a point set: the values belong to no point, e.g. the volume of a cavity. They are those of rank 0, for
  /// all ranks of the receiver.
  static constexpr char global[] = "";

  /// A nodal field that others may receive: `components` values a point, interleaved. `level` names the time level it
  /// carries after a step's tasks, e.g. "n" or "n+1".
  virtual void output(const std::string &name, const std::string &point_set, unsigned components,
                      const std::string &unit, const std::string &level, const std::vector<double> &values) = 0;

  /// A nodal field that others may send. `task`: the only one that reads it; without one every solve does, so that a
  /// sequence has to send it before the first.
  virtual void input(const std::string &name, const std::string &point_set, unsigned components,
                     const std::string &unit, std::vector<double> &values, const std::string &task = "") = 0;

  /// Something a sequence may order by name besides prepare, solve and commit; collective over the ranks.
  virtual void task(const std::string &name, std::function<void(const Step &)> action) = 0;

  /// A number for the history, asked for after each commit on every rank. Not collective: nobody is to wait then.
  virtual void scalar(const std::string &name, const std::string &unit, std::function<double()> value,
                      Combine combine = Combine::first) = 0;

  /// A scalar whose values are the indices of these names, e.g. the phases of the heartbeat.
  virtual void state(const std::string &name, const std::vector<std::string> &names, std::function<int()> value) = 0;
};

/// Life of a solver: prepare (once a step), solve (any number of times, always from the same old state), commit (once).
class Solver {
 public:
  virtual ~Solver() = default;
  virtual void declare(Declaration &declaration) = 0;
  virtual void prepare_step(const Step &step) = 0;
  virtual void solve_step(const Step &step) = 0;
  virtual void commit_step(const Step &step) = 0;
  /// After the commit of `step`: all that the next step depends on, into files of this folder, one for each physics.
  virtual void save_state(const std::string &, const Step &) {}
  /// Instead of the start block: as if `step` had just been committed, outputs included; `step.size` is that of the
  /// steps to come.
  virtual void load_state(const std::string &, const Step &) {}
  /// Drops what speeds up the next steps but is not in the state: preconditioners, tangents, guesses. Ordered at
  /// regular steps whether or not a run is interrupted there, so that one that is goes on with the same bits.
  virtual void refresh() {}
  /// What it times itself, by part of its work; sections are entered by all ranks. The rest counts as "other".
  virtual std::vector<Stopwatch *> stopwatches() { return {}; }
  /// After the last step: last output, summaries.
  virtual void finish() {}
};

} // namespace heartbus::bus
