#pragma once

#include "coupler/sequence/sequence.h"
#include "coupler/sequence/time_control.h"

#include <functional>
#include <map>
#include <tuple>

namespace heartbus::coupler {

/// Number of the route of (sender, receiver, field).
using Routes = std::map<std::tuple<std::string, std::string, std::string>, int>;

/// A sequence as one stream of orders: to whom, what. Each participant executes its own part of the stream in this
/// order, independently of the others but for what it receives, and reports after its commit.
std::vector<std::pair<std::string, bus::Command>> commands(const Nodes &nodes, const Routes &routes, bus::Step step);

/// Executes a sequence through the bus; waits for nobody but at the end of the start block and of each step, when the
/// next one has been ordered already, and where a repetition depends on what somebody reports.
class SequenceRunner {
 public:
  /// Connects the routes that the sequence uses.
  SequenceRunner(bus::Coordinator &coordinator, const Sequence &sequence);

  using Reports = std::map<std::string, bus::Report>; ///< by participant
  Reports start(const bus::Step &step);
  /// With times, which those of steps leave out.
  Reports report(const bus::Step &step);
  /// `pauses`: nothing is ordered beyond this step, since all are to be saved, or to end.
  Reports step(const TimeControl &time, int number, bool pauses);
  /// All participants save or load their states at the end of this step; constants go before what is loaded.
  Reports states(bus::Command::Kind kind, const std::string &folder, const bus::Step &step);
  /// All drop what is not in their state, before the next step.
  void refresh(const bus::Step &step);

  /// The route of a field; Failure(scene) when the sequence does not transfer it.
  int route_of(const std::string &field) const;

 private:
  void connect(const Nodes &nodes);
  void lead(const TimeControl &time, int number);
  void begin(const bus::Step &step);
  void complete(const bus::Step &step);
  /// From `place_` on; does not look at the step's own iteration.
  void order_while(const std::function<bool(const Node &)> &condition, bus::Step step);
  bool is_regular(const Node &node, const bus::Step &step) const; ///< of Kind::every
  bool is_known(const Node &node) const;                          ///< what it waits for, by the last reports
  void order(const Nodes &nodes, const bus::Step &step);
  void repeat_until(const Node &node, bus::Step step);
  void order_all(const bus::Command &command);
  Reports wait_reports();

  bus::Coordinator &coordinator_;
  Sequence sequence_;
  Routes routes_;
  int last_led_ = 0; ///< step that leaders have been told of
  struct Place {
    std::size_t node = 0;
    int iteration = 0;
  };
  Place place_;                                             ///< up to where the step has been ordered
  std::vector<std::pair<std::string, bus::Command>> turns_; ///< to be ordered with the next step
  Reports last_reports_;
};

} // namespace heartbus::coupler
