#include "common/bus/recorders.h"

#include <algorithm>

namespace heartbus::bus {

Recorder::Recorder(const World &world, int route, unsigned components, const std::vector<Peer> &peers,
                   std::size_t n_points, Callback on_values)
    : route_(route), incoming_(world, route, components, peers), values_(components * n_points),
      on_values_(std::move(on_values)) {}

void Recorder::take_arrived() {
  while (n_taken_ < n_expected_ && incoming_.has_arrived()) {
    const Step step = incoming_.take(values_);
    ++n_taken_;
    on_values_(step, values_);
  }
}

void Recorders::add(const World &world, const RouteTable &table, Recorder::Callback on_values) {
  all_.emplace_back(world, table.number, table.field.components, table.peers_of_coupler(world),
                    table.target_coordinates().size() / 3, std::move(on_values));
  sources_.push_back(table.from);
}

void Recorders::ordered(const std::string &participant, const Command &command) {
  for (Recorder &recorder : all_)
    if (command.kind == Command::Kind::send && command.route == recorder.route())
      recorder.expect_one();
  if (command.kind != Command::Kind::report)
    return;
  Counts expected;
  for (const Recorder &recorder : all_)
    expected.push_back(sources_[expected.size()] == participant ? recorder.n_expected() : 0);
  by_report_[participant].push_back(std::move(expected));
}

void Recorders::take_arrived() {
  for (Recorder &recorder : all_)
    recorder.take_arrived();
}

bool Recorders::have(const Counts &expected) {
  take_arrived();
  return std::equal(expected.begin(), expected.end(), all_.begin(),
                    [](int n, const Recorder &recorder) { return recorder.n_taken() >= n; });
}

bool Recorders::have_all() {
  Counts expected;
  for (const Recorder &recorder : all_)
    expected.push_back(recorder.n_expected());
  return have(expected);
}

bool Recorders::have_what_comes_before_report(const std::string &participant) {
  return have(by_report_.at(participant).front());
}

void Recorders::close() {
  for (Recorder &recorder : all_)
    recorder.close();
}

} // namespace heartbus::bus
