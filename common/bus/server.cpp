#include "common/bus/server.h"

#include "common/bus/failure.h"

#include <chrono>
#include <cmath>
#include <sstream>
#include <sys/resource.h>

namespace heartbus::bus {
namespace {

/// Idle participants wait for others much longer than any single answer takes; the coupler watches those who work.
constexpr double patience_of_the_idle = 10;

/// What is not finite must not spread: its origin would be lost.
void check_finite(const std::vector<double> &values, const FieldInfo &field, const std::vector<double> &coordinates,
                  const Step &step) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i])) {
      const double *point = coordinates.data() + i / field.components * 3;
      std::ostringstream message;
      message << "field '" << field.name << "' is " << values[i] << " at point (" << point[0] << ", " << point[1]
              << ", " << point[2] << "), component " << i % field.components << ", " << describe(step)
              << "; it has not been sent";
      throw Failure(ExitCode::not_finite, message.str());
    }
}

double cpu_seconds(const rusage &usage) {
  const auto seconds = [](const timeval &t) { return t.tv_sec + 1e-6 * t.tv_usec; };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

} // namespace

template <class Work>
void Server::measure(const std::string &kind, Work &&work) {
  using namespace std::chrono;
  const auto start = steady_clock::now();
  work();
  seconds_[kind] += duration<double>(steady_clock::now() - start).count();
}

void Server::run() {
  solver_.declare(declared_);
  link_.post(tag_declaration, declared_.info());
  while (!finished_) {
    std::vector<Command> batch;
    measure("idle", [&] { batch = unpack<std::vector<Command>>(link_.receive_broadcast(patience_of_the_idle)); });
    for (const Command &command : batch) {
      execute(command);
      link_.post_progress();
    }
  }
}

void Server::execute(const Command &command) {
  const Step &step = command.step;
  switch (command.kind) {
  case Command::Kind::prepare:
    return prepare(step);
  case Command::Kind::solve:
    return solve(step);
  case Command::Kind::commit:
    return measure("commit", [&] { solver_.commit_step(step); });
  case Command::Kind::task:
    return perform(command.task, step);
  case Command::Kind::send:
    return measure("send", [&] { send(command.route, step); });
  case Command::Kind::receive:
    return measure("receive", [&] { receive(command.route, step); });
  case Command::Kind::report:
    return report();
  case Command::Kind::connect:
    return connect();
  case Command::Kind::finish:
    return finish();
  case Command::Kind::save:
    return measure("save", [&] { solver_.save_state(command.task, step); });
  case Command::Kind::load:
    return measure("load", [&] { solver_.load_state(command.task, step); });
  case Command::Kind::refresh:
    return solver_.refresh();
  }
}

void Server::prepare(const Step &step) {
  measure("prepare", [&] { solver_.prepare_step(step); });
  prepared_step_ = step.number;
  prepared_time_ = step.time;
}

bool Server::is_prepared(const Step &step) const {
  return prepared_step_ == step.number && prepared_time_ == step.time;
}

void Server::solve(const Step &step) {
  if (!is_prepared(step))
    prepare(step);
  measure("solve", [&] { solver_.solve_step(step); });
}

void Server::perform(const std::string &task, const Step &step) {
  const auto found = declared_.tasks().find(task);
  if (found == declared_.tasks().end())
    throw Failure(ExitCode::handshake, "the coupler orders task '" + task + "', which has not been declared");
  measure("task:" + task, [&] { found->second(step); });
}

void Server::connect() {
  const auto row = unpack<RouteRow>(link_.receive(tag_route));
  const LocalDeclaration::Field &field = declared_.field(row.field, row.outgoing);
  link_.connect(row, field.info.components);
  (row.outgoing ? sent_ : received_)[row.route] = &field;
}

void Server::send(int route, const Step &step) {
  const LocalDeclaration::Field &field = *sent_.at(route);
  if (field.source->size() != field.size)
    throw Failure(ExitCode::handshake, "field '" + field.info.name + "' holds " + std::to_string(field.source->size()) +
                                           " values; its point set needs " + std::to_string(field.size));
  check_finite(*field.source, field.info, declared_.coordinates(field.info.point_set), step);
  wait_until_taken(route);
  link_.outgoing.at(route).send(step, *field.source);
}

void Server::wait_until_taken(int route) {
  Outgoing &ends = link_.outgoing.at(route);
  const auto awaited = [&] {
    return Awaited{ends.busy_with() + " to take the previous '" + sent_.at(route)->info.name + "'", ""};
  };
  link_.waiting().until([&] { return ends.idle(); }, awaited);
}

void Server::receive(int route, const Step &step) {
  const LocalDeclaration::Field &field = *received_.at(route);
  Incoming &ends = link_.incoming.at(route);
  const auto awaited = [&] {
    return Awaited{"field '" + field.info.name + "' from " + ends.missing() + ", " + describe(step), ends.sender()};
  };
  link_.waiting().until([&] { return ends.arrived(); }, awaited);
  field.target->resize(field.size);
  if (ends.sender().empty())
    return; // no points on this rank
  const Step sent = ends.take(*field.target);
  if (sent.number != step.number || sent.iteration != step.iteration)
    throw Failure(ExitCode::handshake, "field '" + field.info.name + "' from " + ends.sender() + " is of " +
                                           describe(sent) + ", expected " + describe(step));
}

void Server::report() {
  Report report;
  report.scalars = declared_.scalars();
  std::vector<double> sums;
  for (const auto &[kind, seconds] : seconds_)
    sums.push_back(seconds);
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  sums.push_back(cpu_seconds(usage));
  sums.push_back(usage.ru_maxrss * 1024.); // kilobytes on Linux
  sums = link_.sum(sums);
  auto sum = sums.begin();
  for (const auto &[kind, seconds] : seconds_)
    report.seconds[kind] = *sum++ / link_.local_size();
  report.cpu_seconds = *sum++;
  report.peak_memory = *sum;
  seconds_.clear();
  if (link_.is_root())
    link_.post(tag_report, report);
}

void Server::finish() {
  solver_.finish();
  for (const auto &[route, field] : sent_)
    wait_until_taken(route);
  finished_ = true;
}

} // namespace heartbus::bus
