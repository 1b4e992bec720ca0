#pragma once

#include "common/bus/coordinator.h"

#include <chrono>
#include <deque>
#include <map>
#include <string>
#include <vector>

namespace heartbus::bus {

struct RouteName {
  std::string from, to, field;
};

/// What every participant is doing, as far as the coupler knows: the commands it has been sent and not yet executed.
class Crew {
 public:
  void sent(const std::string &participant, const std::vector<Command> &commands);
  void executed_one(const std::string &participant);
  bool idle(const std::string &participant) const;

  /// Late when somebody has worked on one command longer than `seconds`. Those who wait for others' data are left out:
  /// they complain themselves, and know better for what.
  void watch(double seconds, const std::vector<RouteName> &routes) const;
  /// Follows the chain of who waits for whom to its end, which is the one to blame: "; mech itself waits for 'calcium'
  /// from ep; ep is busy with solve, step 3, iteration 0".
  std::string why_late(std::string participant, const std::vector<RouteName> &routes) const;

 private:
  struct Work {
    std::deque<Command> commands;
    std::chrono::steady_clock::time_point since; ///< when the first of the commands could be started
  };
  std::map<std::string, Work> work_;
};

} // namespace heartbus::bus
