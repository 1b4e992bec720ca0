#pragma once

#include "coupler/sequence/sequence.h"
#include "coupler/time_control.h"

#include <map>
#include <tuple>

namespace heartbus::coupler {

/// Number of the route of (sender, receiver, field).
using Routes = std::map<std::tuple<std::string, std::string, std::string>, int>;

/// A sequence as one stream of orders: to whom, what. Each participant executes its own part of the stream in this
/// order, independently of the others but for what it receives.
std::vector<std::pair<std::string, bus::Command>> commands(const Nodes &nodes, const Routes &routes, bus::Step step);

/// Executes a sequence through the bus; waits for nobody but at the end of the start block and of each step, and where
/// a repetition depends on what somebody reports.
class SequenceRunner {
 public:
  /// Connects the routes that the sequence uses. Leaders are told of so many steps in advance.
  SequenceRunner(bus::Coordinator &coordinator, const Sequence &sequence, int lookahead);

  using Reports = std::map<std::string, bus::Report>; ///< by participant
  Reports start(const bus::Step &step);
  Reports step(const TimeControl &time, int number);
  /// All participants save or load their states at the end of this step.
  Reports states(bus::Command::Kind kind, const std::string &folder, const bus::Step &step);
  /// All drop what is not in their state, before the next step.
  void refresh(const bus::Step &step);

  /// The route of a field; Failure(scene) when the sequence does not transfer it.
  int route_of(const std::string &field) const;

 private:
  void connect(const Nodes &nodes);
  bool is_due(const Node &node, const bus::Step &step) const;
  void order(const Nodes &nodes, const bus::Step &step);
  void order_leaders(const bus::Step &step);
  void follow(bus::Step step);
  /// Leaves the last iteration in `step`.
  void repeat_until(const Node &node, bus::Step &step);
  void order_all(const bus::Command &command);
  Reports wait_reports();

  bus::Coordinator &coordinator_;
  Sequence sequence_;
  Routes routes_;
  int lookahead_, last_led_ = 0;                   ///< of steps; the last one that leaders have been told of
  std::set<std::string> leaders_;                  ///< only with look-ahead
  std::map<std::string, bus::Times> times_before_; ///< reported within the step
  Reports last_reports_;
};

} // namespace heartbus::coupler
