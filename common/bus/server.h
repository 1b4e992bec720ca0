#pragma once

#include "common/bus/declaration.h"
#include "common/bus/link.h"
#include "common/bus/trace.h"

#include <map>
#include <optional>
#include <string>

namespace heartbus::bus {

/// Executes the coupler's commands on one rank of a participant, in the order received, and keeps the time. What only
/// the solver can do it hands out:
///
///     solver.declare(server.declaration());
///     server.open(solver.stopwatches());
///     while (const Command *command = server.next())
///       execute(*command, solver);
class Server {
 public:
  explicit Server(Link &link) : link_(link) {}

  LocalDeclaration &declaration() { return declared_; }
  /// Tells the coupler what has been declared. The stopwatches are those of the solver.
  void open(const std::vector<Stopwatch *> &stopwatches);
  /// The next command for the solver (prepare, solve, commit, task, save, load, refresh, finish), which it has executed
  /// when it calls again; each solve comes after a prepare of its step. Null when all is done.
  const Command *next();
  bool has_finished() const { return finished_; }

  bool sends_anything = false; ///< also what is not finite

 private:
  /// A command under way: time counts for it and its part of the work.
  struct Work {
    Work(Stopwatch &commands, Stopwatch &parts, const Command &command);
    Stopwatch::Section command, part;
  };
  const Command &take();
  void begin(const Command &command);
  void end();
  std::vector<Command> next_batch();
  void ring();
  bool is_for_solver(const Command &command);
  void execute(const Command &command);
  bool is_prepared(const Step &step) const;
  void connect();
  void send(int route, const Step &step);
  void wait_until_taken(int route);
  void receive(int route, const Step &step);
  void report(bool with_times);
  Seconds take_parts();
  void begin_trace();
  void hand_over_trace();
  const std::string &label(const std::string &kind) const; ///< of a slice of the trace

  Link &link_;
  LocalDeclaration declared_;
  std::vector<Stopwatch *> stopwatches_;
  struct Transfer {
    const LocalDeclaration::Field *field;
    std::string label; ///< "send calcium"
  };
  std::map<int, Transfer> sent_, received_; ///< by route
  std::vector<Command> batch_;
  std::size_t n_taken_ = 0; ///< of the batch
  Command implied_;         ///< a prepare that nobody has ordered
  int prepared_step_ = -1;
  double prepared_time_ = 0;
  Stopwatch commands_, parts_; ///< by command; as work of the solver, of the bus, and waiting
  std::optional<Trace> trace_;
  const Command *command_ = nullptr; ///< being executed
  std::optional<Work> work_;
  std::vector<int> to_be_rung_; ///< ranks of the world to whom something has been sent
  bool finished_ = false;
};

} // namespace heartbus::bus
