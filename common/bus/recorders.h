#pragma once

#include "common/bus/route_table.h"
#include "common/bus/transfer.h"

#include <deque>
#include <functional>
#include <list>
#include <map>
#include <string>
#include <vector>

namespace heartbus::bus {

/// Receives at the coupler what travels on a route and hands it on.
class Recorder {
 public:
  using Callback = std::function<void(const Step &, const std::vector<double> &)>;
  Recorder(const World &world, int route, unsigned components, const std::vector<Peer> &peers, std::size_t n_points,
           Callback on_values);
  void expect_one() { ++n_expected_; }
  int n_expected() const { return n_expected_; } ///< since the start
  int n_taken() const { return n_taken_; }
  void take_arrived();
  int route() const { return route_; }
  void close() { incoming_.close(); }

 private:
  int route_, n_expected_ = 0, n_taken_ = 0;
  Incoming incoming_;
  std::vector<double> values_;
  Callback on_values_;
};

/// All that is recorded of a run. Who sends more than two messages waits until the first has been taken.
class Recorders {
 public:
  void add(const World &world, const RouteTable &table, Recorder::Callback on_values);
  bool empty() const { return all_.empty(); }
  /// One more command has been ordered of a participant: of what it sends a message is expected, and its report ends
  /// what has been ordered before.
  void ordered(const std::string &participant, const Command &command);
  void take_arrived();
  bool have_all();                                                    ///< that has been ordered so far
  bool have_what_comes_before_report(const std::string &participant); ///< the oldest one
  void forget_report(const std::string &participant) { by_report_.at(participant).pop_front(); }
  void close();

 private:
  using Counts = std::vector<int>; ///< [recorder]
  bool have(const Counts &expected);

  std::list<Recorder> all_;
  std::vector<std::string> sources_;                    ///< [recorder]
  std::map<std::string, std::deque<Counts>> by_report_; ///< expected before each report that has been ordered
};

} // namespace heartbus::bus
