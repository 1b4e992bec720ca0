#include "coupler/sequence/sequence_runner.h"

#include "common/units/nearest.h"
#include "common/units/units.h"

#include <algorithm>

namespace heartbus::coupler {

namespace {

bus::Command::Kind kind_of(const Node &node) {
  using Kind = bus::Command::Kind;
  return node.kind == Node::Kind::prepare ? Kind::prepare
         : node.kind == Node::Kind::solve ? Kind::solve
         : node.kind == Node::Kind::task  ? Kind::task
                                          : Kind::commit;
}

double reported(const std::string &scalar, const bus::ParticipantInfo &participant, const bus::Report &report) {
  const auto &scalars = participant.scalars;
  const auto found = std::find_if(scalars.begin(), scalars.end(), [&](const auto &s) { return s.name == scalar; });
  if (found == scalars.end())
    throw Failure(ExitCode::handshake,
                  "the scheme waits for '" + scalar + "', which '" + participant.name + "' does not report");
  return report.scalars.at(found - scalars.begin());
}

} // namespace

std::vector<std::pair<std::string, bus::Command>> commands(const Nodes &nodes, const Routes &routes, bus::Step step) {
  using Kind = bus::Command::Kind;
  std::vector<std::pair<std::string, bus::Command>> stream, reports, turns;
  for (const auto &[node, iteration] : flatten(nodes, step.iteration)) {
    step.iteration = iteration;
    if (node.kind == Node::Kind::transfer) {
      const int route = routes.at({node.participant, node.receiver, node.field});
      stream.push_back({node.participant, {Kind::send, "", route, step}});
      stream.push_back({node.receiver, {Kind::receive, "", route, step}});
    } else if (node.kind == Node::Kind::turn) {
      stream.push_back({node.participant, {Kind::notify, node.receiver, -1, step}});
      bus::Step taken = step;
      taken.number += node.times;
      (node.times > 0 ? turns : stream).push_back({node.receiver, {Kind::wait, node.participant, -1, taken}});
    } else
      stream.push_back({node.participant, {kind_of(node), node.task, -1, step}});
    if (node.kind == Node::Kind::commit)
      reports.push_back({node.participant, {Kind::report, bus::Command::scalars_only, -1, step}});
  }
  // Nobody is kept waiting for his turn by a report, nor for a report by who waits for his turn.
  stream.insert(stream.end(), reports.begin(), reports.end());
  stream.insert(stream.end(), turns.begin(), turns.end());
  return stream;
}

SequenceRunner::SequenceRunner(bus::Coordinator &coordinator, const Sequence &sequence)
    : coordinator_(coordinator), sequence_(sequence) {
  connect(sequence_.constants);
  connect(sequence_.start);
  connect(sequence_.step);
}

void SequenceRunner::connect(const Nodes &nodes) {
  for (const auto &[node, iteration] : flatten(nodes))
    if (node.kind == Node::Kind::transfer)
      if (const auto [at, is_new] = routes_.insert({{node.participant, node.receiver, node.field}, -1}); is_new)
        at->second = coordinator_.connect(node.participant, node.receiver, node.field);
}

SequenceRunner::Reports SequenceRunner::start(const bus::Step &step) {
  order(sequence_.constants, step);
  order(sequence_.start, step);
  return report(step);
}

SequenceRunner::Reports SequenceRunner::report(const bus::Step &step) {
  order_all({bus::Command::Kind::report, "", -1, step});
  return wait_reports();
}

SequenceRunner::Reports SequenceRunner::step(const TimeControl &time, int number, bool pauses) {
  lead(time, number);
  complete(time.step(number));
  for (const auto &[participant, command] : turns_)
    coordinator_.order(participant, command);
  turns_.clear();
  if (!pauses && time.refreshes_at(number))
    refresh(time.step(number));
  if (!pauses && number < time.n_steps())
    begin(time.step(number + 1));
  return wait_reports();
}

/// Leaders are told of this step and of some more.
void SequenceRunner::lead(const TimeControl &time, int number) {
  const int last = std::min(number + sequence_.ahead, time.next_refresh(number));
  for (int n = std::max(number, last_led_ + 1); n <= last; ++n)
    for (const auto &[participant, command] : commands(sequence_.step, routes_, time.step(n)))
      if (sequence_.source_participants.count(participant))
        coordinator_.order(participant, command);
  last_led_ = last;
}

/// What others do in a step, as far as that is known before the reports of the step before. So nobody waits for the
/// coupler between two steps.
void SequenceRunner::begin(const bus::Step &step) {
  const auto is_foreseeable = [&](const Node &node) {
    return node.kind == Node::Kind::every ? is_regular(node, step) || is_known(node) : node.kind != Node::Kind::until;
  };
  order_while(is_foreseeable, step);
}

/// The rest of a step.
void SequenceRunner::complete(const bus::Step &step) {
  const auto is_fixed = [](const Node &node) { return node.kind != Node::Kind::until; };
  order_while(is_fixed, step);
  while (place_.node < sequence_.step.size()) {
    repeat_until(sequence_.step[place_.node++], step);
    order_while(is_fixed, step);
  }
  place_ = {};
}

void SequenceRunner::order_while(const std::function<bool(const Node &)> &condition, bus::Step step) {
  Nodes due;
  for (; place_.node < sequence_.step.size() && condition(sequence_.step[place_.node]); ++place_.node) {
    const Node &node = sequence_.step[place_.node];
    if (node.kind != Node::Kind::every || is_regular(node, step) || !is_known(node))
      due.push_back(node);
  }
  step.iteration = place_.iteration;
  order(due, step);
  if (const auto actions = flatten(due, place_.iteration); !actions.empty())
    place_.iteration = actions.back().iteration;
}

/// The first time is in the start block; where it is not, it is due as long as the scalar is not known.
bool SequenceRunner::is_regular(const Node &node, const bus::Step &step) const {
  return step.number > 1 && (step.number - 1) % node.times == 0;
}

bool SequenceRunner::is_known(const Node &node) const {
  return reported(node.field, coordinator_.participant(node.participant), last_reports_.at(node.participant)) != 0;
}

/// Who takes a turn is told so together with what it does next: orders pass from rank to rank, which takes time.
void SequenceRunner::order(const Nodes &nodes, const bus::Step &step) {
  for (const auto &[participant, command] : commands(nodes, routes_, step))
    if (command.step.number > step.number)
      turns_.push_back({participant, command});
    else if (!sequence_.source_participants.count(participant))
      coordinator_.order(participant, command);
}

void SequenceRunner::repeat_until(const Node &node, bus::Step step) {
  double value = 0;
  for (step.iteration = 0; step.iteration < node.times; ++step.iteration) {
    place_.iteration = step.iteration;
    order(node.body, step);
    coordinator_.order(node.participant, {bus::Command::Kind::report, bus::Command::scalars_only, -1, step});
    coordinator_.flush();
    const bus::Report report = coordinator_.wait_report(node.participant);
    value = reported(node.field, coordinator_.participant(node.participant), report);
    if (value < node.limit)
      return;
  }
  if (node.required)
    throw Failure(ExitCode::not_converged, "step " + std::to_string(step.number) +
                                               ": blood and wall do not agree after " + std::to_string(node.times) +
                                               " iterations: '" + node.field + "' is " + config::shortest(value) +
                                               " where " + config::shortest(node.limit) + " is wanted; allow more " +
                                               (node.where.empty() ? "'coupling.iterations'" : "at " + node.where) +
                                               ", or help them by 'coupling.acceleration: anderson' "
                                               "or 'coupling.alpha: auto'");
}

SequenceRunner::Reports SequenceRunner::states(bus::Command::Kind kind, const std::string &folder,
                                               const bus::Step &step) {
  if (kind == bus::Command::Kind::load)
    order(sequence_.constants, step);
  order_all({kind, folder, -1, step});
  return report(step);
}

void SequenceRunner::refresh(const bus::Step &step) { order_all({bus::Command::Kind::refresh, "", -1, step}); }

void SequenceRunner::order_all(const bus::Command &command) {
  for (const auto &participant : coordinator_.participants())
    coordinator_.order(participant.name, command);
}

SequenceRunner::Reports SequenceRunner::wait_reports() {
  coordinator_.flush();
  Reports reports;
  for (const auto &participant : coordinator_.participants())
    reports[participant.name] = coordinator_.wait_report(participant.name);
  last_reports_ = reports;
  return reports;
}

int SequenceRunner::route_of(const std::string &field) const {
  std::vector<std::string> fields;
  for (const auto &[ends, route] : routes_) {
    if (std::get<2>(ends) == field)
      return route;
    fields.push_back(std::get<2>(ends));
  }
  throw Failure(ExitCode::scene, "--record " + field + ": this run transfers no such field" +
                                     config::did_you_mean(field, fields) + " Fields: " + config::joined(fields));
}

} // namespace heartbus::coupler
