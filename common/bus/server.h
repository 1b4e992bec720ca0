#pragma once

#include "common/bus/declaration.h"
#include "common/bus/link.h"

#include <map>
#include <string>

namespace heartbus::bus {

/// Executes the coupler's commands on one rank of a participant, in the order received, and keeps the time.
class Server {
 public:
  Server(Solver &solver, Link &link) : solver_(solver), link_(link) {}
  /// Declares, then works until the command to finish.
  void run();

 private:
  void execute(const Command &command);
  void prepare(const Step &step);
  bool is_prepared(const Step &step) const;
  void solve(const Step &step);
  void perform(const std::string &task, const Step &step);
  void connect();
  void send(int route, const Step &step);
  void wait_until_taken(int route);
  void receive(int route, const Step &step);
  void report();
  void finish();
  template <class Work>
  void measure(const std::string &kind, Work &&work);

  Solver &solver_;
  Link &link_;
  LocalDeclaration declared_;
  std::map<int, const LocalDeclaration::Field *> sent_, received_; ///< by route
  int prepared_step_ = -1;
  double prepared_time_ = 0;
  std::map<std::string, double> seconds_; ///< since the last report
  bool finished_ = false;
};

} // namespace heartbus::bus
