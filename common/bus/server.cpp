#include "common/bus/server.h"

#include "common/base/failure.h"

#include <cmath>
#include <sstream>
#include <sys/resource.h>

namespace heartbus::bus {
namespace {

/// Idle participants wait for others much longer than any single answer takes; the coupler watches those who work.
constexpr double patience_of_the_idle = 10;

/// What is not finite, or soon will not be, must not spread: its origin would be lost.
[[noreturn]] void name_what_is_implausible(const std::vector<double> &values, const FieldInfo &field,
                                           const std::vector<double> &coordinates, const Step &step) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!(std::abs(values[i]) <= largest_plausible)) {
      std::ostringstream message;
      message << "field '" << field.name << "' is " << values[i];
      if (!field.is_global()) {
        const double *point = coordinates.data() + i / field.components * 3;
        message << " at point (" << point[0] << ", " << point[1] << ", " << point[2] << ")";
      }
      message << ", component " << i % field.components << ", " << describe(step) << "; it has not been sent";
      throw Failure(ExitCode::not_finite, message.str());
    }
  throw Failure(ExitCode::not_finite, "field '" + field.name + "' is not finite, " + describe(step));
}

double cpu_seconds(const rusage &usage) {
  const auto seconds = [](const timeval &t) { return t.tv_sec + 1e-6 * t.tv_usec; };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Part of the work to which a command belongs.
std::string whose(const Command &command) {
  switch (command.kind) {
  case Command::Kind::send:
  case Command::Kind::receive:
  case Command::Kind::report:
  case Command::Kind::connect:
  case Command::Kind::trace:
  case Command::Kind::notify:
  case Command::Kind::wait:
    return "bus";
  case Command::Kind::save:
  case Command::Kind::load:
    return "checkpoint";
  default:
    return "solver";
  }
}

} // namespace

Server::Work::Work(Stopwatch &commands, Stopwatch &parts, const Command &of)
    : command(commands, kind_of_work(of)), part(parts, whose(of)) {}

void Server::open(const std::vector<Stopwatch *> &stopwatches) {
  stopwatches_ = stopwatches;
  link_.post(tag_declaration, declared_.info());
}

const Command *Server::next() {
  if (command_)
    end();
  while (!finished_) {
    begin(take());
    if (is_for_solver(*command_))
      return command_;
    execute(*command_);
    end();
  }
  if (trace_)
    hand_over_trace();
  return nullptr;
}

const Command &Server::take() {
  while (n_taken_ == batch_.size()) {
    batch_ = next_batch();
    n_taken_ = 0;
  }
  const Command &command = batch_[n_taken_];
  if (command.kind == Command::Kind::solve && !is_prepared(command.step))
    return implied_ = {Command::Kind::prepare, "", -1, command.step};
  ++n_taken_;
  return command;
}

void Server::begin(const Command &command) {
  if (command.kind != Command::Kind::send)
    ring();
  command_ = &command;
  work_.emplace(commands_, parts_, command);
}

void Server::end() {
  if (command_->kind == Command::Kind::prepare) {
    prepared_step_ = command_->step.number;
    prepared_time_ = command_->step.time;
  }
  if (command_->kind == Command::Kind::finish) {
    for (const auto &[route, transfer] : sent_)
      wait_until_taken(route);
    finished_ = true;
  }
  work_.reset();
  if (command_ != &implied_)
    link_.post_progress();
  command_ = nullptr;
}

/// After the last of several fields: who wakes for the first one would have to wait for the others. Who wakes may take
/// this core.
void Server::ring() {
  if (to_be_rung_.empty())
    return;
  const Stopwatch::Section waiting(parts_, "waiting");
  link_.bells().ring(to_be_rung_);
  to_be_rung_.clear();
}

std::vector<Command> Server::next_batch() {
  ring();
  const Stopwatch::Section idle(commands_, "idle"), waiting(parts_, "waiting");
  return unpack<std::vector<Command>>(link_.receive_broadcast(patience_of_the_idle));
}

bool Server::is_for_solver(const Command &command) {
  switch (command.kind) {
  case Command::Kind::task:
    if (declared_.tasks().count(command.task) == 0)
      throw Failure(ExitCode::handshake, "the coupler orders task '" + command.task + "', which has not been declared");
    return true;
  case Command::Kind::prepare:
  case Command::Kind::solve:
  case Command::Kind::commit:
  case Command::Kind::finish:
  case Command::Kind::save:
  case Command::Kind::load:
  case Command::Kind::refresh:
    return true;
  default:
    return false;
  }
}

void Server::execute(const Command &command) {
  const Step &step = command.step;
  switch (command.kind) {
  case Command::Kind::send:
    return send(command.route, step);
  case Command::Kind::receive:
    return receive(command.route, step);
  case Command::Kind::report:
    return report(command.task != Command::scalars_only);
  case Command::Kind::connect:
    return connect();
  case Command::Kind::trace:
    return begin_trace();
  case Command::Kind::notify:
    return link_.notify(command.task, to_be_rung_);
  case Command::Kind::wait: {
    const Stopwatch::Section waiting(parts_, "waiting");
    return link_.wait(command.task);
  }
  default:
    return; // of the solver
  }
}

bool Server::is_prepared(const Step &step) const {
  return prepared_step_ == step.number && prepared_time_ == step.time;
}

void Server::connect() {
  const auto row = unpack<RouteRow>(link_.receive(tag_route, "a routing table of the coupler", "coupler"));
  const LocalDeclaration::Field &field = declared_.field(row.field, row.outgoing);
  link_.connect(row, field.info.components);
  (row.outgoing ? sent_ : received_)[row.route] = {&field, (row.outgoing ? "send " : "receive ") + row.field};
}

void Server::send(int route, const Step &step) {
  const LocalDeclaration::Field &field = *sent_.at(route).field;
  if (field.source->size() != field.size)
    throw Failure(ExitCode::handshake, "field '" + field.info.name + "' holds " + std::to_string(field.source->size()) +
                                           " values; its point set needs " + std::to_string(field.size));
  wait_until_taken(route);
  Outgoing &ends = link_.outgoing.at(route);
  ends.pack(step, *field.source);
  if (!sends_anything && !ends.is_plausible())
    name_what_is_implausible(
        *field.source, field.info,
        field.info.is_global() ? std::vector<double>() : declared_.coordinates(field.info.point_set), step);
  ends.send();
  ends.add_receivers(to_be_rung_);
}

void Server::wait_until_taken(int route) {
  Outgoing &ends = link_.outgoing.at(route);
  if (ends.is_free())
    return;
  ring();
  const auto awaited = [&] {
    return Awaited{ends.busy_with() + " to take the previous '" + sent_.at(route).field->info.name + "'", ""};
  };
  const Stopwatch::Section waiting(parts_, "waiting");
  WaitHistory history;
  const auto is_free = [&] {
    history.callers = ends.takers();
    return ends.is_free();
  };
  link_.waiting().until(is_free, awaited, 1, &history);
}

void Server::receive(int route, const Step &step) {
  const LocalDeclaration::Field &field = *received_.at(route).field;
  Incoming &ends = link_.incoming.at(route);
  const auto awaited = [&] {
    return Awaited{"field '" + field.info.name + "' from " + ends.missing() + ", " + describe(step), ends.sender()};
  };
  if (WaitHistory &history = ends.history(step); !ends.has_arrived()) {
    const Stopwatch::Section waiting(parts_, "waiting");
    const auto has_arrived = [&] {
      history.callers = ends.callers();
      return history.callers == 0;
    };
    link_.waiting().until(has_arrived, awaited, 1, &history);
  }
  field.target->resize(field.size);
  if (ends.sender().empty())
    return; // no points on this rank
  const Step sent = ends.take(*field.target);
  if (sent.number != step.number || sent.iteration != step.iteration)
    throw Failure(ExitCode::handshake, "field '" + field.info.name + "' from " + ends.sender() + " is of " +
                                           describe(sent) + ", expected " + describe(step));
}

void Server::report(bool with_times) {
  Report report;
  report.scalars = declared_.scalars();
  if (with_times)
    report.times = {commands_.take(), take_parts()};
  for (Seconds *seconds : {&report.times.commands, &report.times.parts})
    for (auto &entry : *seconds)
      entry.second /= link_.local_size();
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  report.cpu_seconds = cpu_seconds(usage);
  report.peak_memory = usage.ru_maxrss * 1024.; // kilobytes on Linux
  report.n_overslept = link_.waiting().n_overslept();
  if (!link_.is_root())
    return link_.post_share(report);
  std::vector<Report> shares;
  {
    const Stopwatch::Section waiting(parts_, "waiting"); // for the slowest rank
    shares = link_.receive_shares();
  }
  for (const Report &share : shares) {
    declared_.combine(share.scalars, report.scalars);
    report.times += share.times;
    report.cpu_seconds += share.cpu_seconds;
    report.peak_memory += share.peak_memory;
    report.n_overslept += share.n_overslept;
  }
  link_.post(tag_report, report);
}

/// The solver's time by its own sections; what it does outside them is "other".
Seconds Server::take_parts() {
  Seconds parts = parts_.take();
  double other = parts["solver"];
  parts.erase("solver");
  for (Stopwatch *stopwatch : stopwatches_) {
    const Seconds sections = stopwatch->take();
    other -= total(sections);
    add(sections, parts);
  }
  parts["other"] += other;
  return parts;
}

void Server::begin_trace() {
  trace_.emplace();
  commands_.on_section = [this](const std::string &kind, Stopwatch::Time begin, Stopwatch::Time end) {
    if (kind != "idle")
      trace_->add(label(kind), begin, end, command_->step);
  };
  for (Stopwatch *stopwatch : stopwatches_)
    stopwatch->on_section = [this](const std::string &part, Stopwatch::Time begin, Stopwatch::Time end) {
      trace_->add(part, begin, end, command_->step);
    };
}

const std::string &Server::label(const std::string &kind) const {
  const bool sends = command_->kind == Command::Kind::send, receives = command_->kind == Command::Kind::receive;
  return sends || receives ? (sends ? sent_ : received_).at(command_->route).label : kind;
}

void Server::hand_over_trace() {
  for (Stopwatch *stopwatch : stopwatches_)
    stopwatch->on_section = nullptr;
  link_.post(tag_trace, *trace_);
  trace_.reset();
}

} // namespace heartbus::bus
