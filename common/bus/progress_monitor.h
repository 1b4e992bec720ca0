#pragma once

#include "common/bus/coordinator.h"

#include <chrono>
#include <deque>
#include <map>
#include <string>
#include <tuple>
#include <vector>

namespace heartbus::bus {

struct RouteName {
  std::string from, to, field;
};

/// What every participant is doing, as far as the coupler knows: the commands it has been sent and not yet executed.
class ProgressMonitor {
 public:
  void sent(const std::string &participant, const std::vector<Command> &commands);
  void executed_one(const std::string &participant);
  bool idle(const std::string &participant) const;
  int step() const; ///< that somebody is at, the earliest; the last one when nobody has anything to do

  /// Late when somebody has worked on one command longer than `seconds`. Those who wait for others' data are left out:
  /// they complain themselves, and know better for what.
  void watch(double seconds, const std::vector<RouteName> &routes) const;
  /// Follows the chain of who waits for whom to its end, which is the one to blame: "; mech itself waits for 'calcium'
  /// from ep; ep is busy with solve, step 3, iteration 0". Who does not take what has been sent is to blame himself,
  /// unless it is `alive`, whose first rank has just complained.
  std::string why_late(std::string participant, const std::vector<RouteName> &routes,
                       const std::string &alive = "") const;

 private:
  struct Work {
    std::deque<Command> commands;
    std::chrono::steady_clock::time_point since; ///< when the first of the commands could be started
  };
  std::map<std::string, Work> work_;
  /// What has been sent and not been taken yet, by (from, to, route), -1 of turns: sends executed less receives.
  std::map<std::tuple<std::string, std::string, int>, int> under_way_;
  int last_step_ = 0;
};

} // namespace heartbus::bus
