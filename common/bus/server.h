#pragma once

#include "common/bus/declaration.h"
#include "common/bus/link.h"
#include "common/bus/trace.h"

#include <map>
#include <optional>
#include <string>

namespace heartbus::bus {

/// Executes the coupler's commands on one rank of a participant, in the order received, and keeps the time.
class Server {
 public:
  Server(Solver &solver, Link &link) : solver_(solver), link_(link) {}
  /// Declares, then works until the command to finish.
  void run();

 private:
  std::vector<Command> next_batch();
  void ring();
  void execute(const Command &command);
  void prepare(const Step &step);
  bool is_prepared(const Step &step) const;
  void solve(const Step &step);
  void perform(const std::string &task, const Step &step);
  void connect();
  void send(int route, const Step &step);
  void wait_until_taken(int route);
  void receive(int route, const Step &step);
  void report(bool with_times);
  Seconds take_parts();
  void finish();
  void begin_trace();
  void hand_over_trace();
  const std::string &label(const std::string &kind) const; ///< of a slice of the trace

  Solver &solver_;
  Link &link_;
  LocalDeclaration declared_;
  struct Transfer {
    const LocalDeclaration::Field *field;
    std::string label; ///< "send calcium"
  };
  std::map<int, Transfer> sent_, received_; ///< by route
  int prepared_step_ = -1;
  double prepared_time_ = 0;
  Stopwatch commands_, parts_; ///< by command; as work of the solver, of the bus, and waiting
  std::optional<Trace> trace_;
  const Command *command_ = nullptr; ///< being executed
  std::vector<int> to_be_rung_;      ///< ranks of the world to whom something has been sent
  bool finished_ = false;
};

} // namespace heartbus::bus
