#pragma once

#include "common/bus/protocol.h"
#include "common/bus/world.h"
#include "common/mapping/conforming_map.h"

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

} // namespace heartbus::bus
