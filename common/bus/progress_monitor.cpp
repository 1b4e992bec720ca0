#include "common/bus/progress_monitor.h"

#include "common/bus/protocol.h"
#include "common/bus/waiting.h"

#include <algorithm>
#include <limits>
#include <sstream>

namespace heartbus::bus {

namespace {

bool waits_for_others(const Command &command) {
  return command.kind == Command::Kind::receive || command.kind == Command::Kind::wait;
}

} // namespace

void ProgressMonitor::sent(const std::string &participant, const std::vector<Command> &commands) {
  Work &work = work_[participant];
  if (work.commands.empty())
    work.since = std::chrono::steady_clock::now();
  work.commands.insert(work.commands.end(), commands.begin(), commands.end());
}

void ProgressMonitor::executed_one(const std::string &participant) {
  Work &work = work_[participant];
  const Command &command = work.commands.front();
  last_step_ = command.step.number;
  if (command.kind == Command::Kind::send)
    ++under_way_[{"", "", command.route}];
  if (command.kind == Command::Kind::receive)
    --under_way_[{"", "", command.route}];
  if (command.kind == Command::Kind::notify)
    ++under_way_[{participant, command.task, -1}];
  if (command.kind == Command::Kind::wait)
    --under_way_[{command.task, participant, -1}];
  work.commands.pop_front();
  work.since = std::chrono::steady_clock::now();
}

bool ProgressMonitor::idle(const std::string &participant) const {
  const auto work = work_.find(participant);
  return work == work_.end() || work->second.commands.empty();
}

int ProgressMonitor::step() const {
  int first = std::numeric_limits<int>::max();
  for (const auto &[participant, work] : work_)
    if (!work.commands.empty() && work.commands.front().step.number > 0)
      first = std::min(first, work.commands.front().step.number);
  return first == std::numeric_limits<int>::max() ? last_step_ : first;
}

void ProgressMonitor::watch(double seconds, const std::vector<RouteName> &routes) const {
  const auto now = std::chrono::steady_clock::now();
  for (const auto &[participant, work] : work_) {
    if (work.commands.empty() || waits_for_others(work.commands.front()) ||
        now - work.since < std::chrono::duration<double>(seconds))
      continue;
    std::ostringstream message;
    message << "waited " << seconds << " s (the deadline) for " << participant << why_late(participant, routes);
    throw Late(message.str(), "");
  }
}

std::string ProgressMonitor::why_late(std::string participant, const std::vector<RouteName> &routes,
                                      const std::string &alive) const {
  std::string chain;
  for (std::size_t link = 0; link <= work_.size(); ++link) {
    if (idle(participant))
      return chain + "; " + participant + " has not been ordered to do anything more";
    const Command &command = work_.at(participant).commands.front();
    if (!waits_for_others(command))
      return chain + "; " + participant + " is busy with " + kind_of_work(command) + ", " + describe(command.step);
    const bool takes_turn = command.kind == Command::Kind::wait;
    const std::string what = takes_turn ? "its turn" : "'" + routes.at(command.route).field + "'",
                      from = takes_turn ? command.task : routes.at(command.route).from;
    const auto sent =
        under_way_.find(takes_turn ? std::tuple{from, participant, -1} : std::tuple{"", "", command.route});
    if (sent != under_way_.end() && sent->second > 0)
      return chain + (participant == alive ? "; rank 0 of " + from + " has sent " + what + " to " + participant +
                                                 ": its ranks that are missing are stopped or stuck"
                                           : "; " + participant + " does not take " + what + ", which " + from +
                                                 " has sent: its rank 0 is stopped or stuck");
    chain += "; " + participant + " itself waits for " + what + " from " + from;
    participant = from;
  }
  return chain + ": they wait for each other";
}

} // namespace heartbus::bus
