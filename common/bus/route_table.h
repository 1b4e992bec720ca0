#pragma once

#include "common/bus/protocol.h"
#include "common/bus/transfer.h"
#include "common/bus/world.h"
#include "common/mapping/conforming_map.h"

#include <functional>
#include <string>
#include <vector>

namespace heartbus::bus {

/// A field on its way from one participant to another, as the coupler plans it: which rank sends what to which.
class RouteTable {
 public:
  /// Failure(handshake) or Failure(map) when the two do not fit.
  RouteTable(int number, const ParticipantInfo &from, const ParticipantInfo &to, const std::string &field);

  RouteRow row_of_source(const World &world, int rank) const;
  RouteRow row_of_target(const World &world, int rank) const;

  /// The coupler as one more receiver: what it gets from each source rank, in the order of target ranks and points.
  RouteRow row_of_source_to_coupler(const World &world, int rank) const;
  std::vector<Peer> peers_of_coupler(const World &world) const;
  std::vector<double> target_coordinates() const;

  const int number;
  const std::string from, to;
  const FieldInfo field;

 private:
  RouteTable(int number, const ParticipantInfo &from, const ParticipantInfo &to,
             const std::pair<FieldInfo, FieldInfo> &agreed);
  mapping::DistributedPoints target_;
  std::vector<mapping::Block> blocks_;
};

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

} // namespace heartbus::bus
