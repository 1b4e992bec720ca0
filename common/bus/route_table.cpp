#include "common/bus/route_table.h"

#include "common/base/failure.h"
#include "common/bus/handshake.h"

namespace heartbus::bus {
namespace {

mapping::DistributedPoints points_of(const ParticipantInfo &participant, const std::string &set_name) {
  const PointSetInfo &set = point_set(participant, set_name);
  return {participant.name + "." + set_name, set.coordinates, set.spacing};
}

} // namespace

RouteTable::RouteTable(int number, const ParticipantInfo &from, const ParticipantInfo &to, const std::string &field)
    : RouteTable(number, from, to, agree_on_field(from, to, field)) {}

RouteTable::RouteTable(int number, const ParticipantInfo &from, const ParticipantInfo &to,
                       const std::pair<FieldInfo, FieldInfo> &agreed)
    : number(number), from(from.name), to(to.name), field(agreed.first) {
  if (field.is_global()) {
    for (int rank = 0; rank < to.n_ranks; ++rank)
      blocks_.push_back({0, rank, {0}, {0}});
    return;
  }
  target_ = points_of(to, agreed.second.point_set);
  const mapping::DistributedPoints source = points_of(from, agreed.first.point_set);
  try {
    blocks_ = mapping::split_by_ranks(mapping::match_points(source, target_), source, target_);
  } catch (const Failure &failure) {
    throw Failure(failure.code(), "field '" + field.name + "': " + failure.what());
  }
}

RouteRow RouteTable::row_of_source(const World &world, int rank) const {
  RouteRow row{number, true, field.name, {}};
  for (const mapping::Block &block : blocks_)
    if (block.source_rank == rank)
      row.peers.push_back({world.ranks_of(to)[block.target_rank], to, block.target_rank, block.source_points});
  return row;
}

RouteRow RouteTable::row_of_target(const World &world, int rank) const {
  RouteRow row{number, false, field.name, {}};
  for (const mapping::Block &block : blocks_)
    if (block.target_rank == rank)
      row.peers.push_back({world.ranks_of(from)[block.source_rank], from, block.source_rank, block.target_points});
  return row;
}

RouteRow RouteTable::row_of_source_to_coupler(const World &world, int rank) const {
  RouteRow row{number, true, field.name, {}};
  Peer coupler{world.coupler(), "coupler", 0, {}};
  for (const mapping::Block &block : blocks_)
    if (block.source_rank == rank)
      coupler.points.insert(coupler.points.end(), block.source_points.begin(), block.source_points.end());
  if (!coupler.points.empty())
    row.peers.push_back(coupler);
  return row;
}

std::vector<Peer> RouteTable::peers_of_coupler(const World &world) const {
  std::vector<int> first_point(1, 0); // of each target rank
  for (const auto &coordinates : target_.coordinates)
    first_point.push_back(first_point.back() + coordinates.size() / 3);
  std::vector<Peer> peers;
  for (const mapping::Block &block : blocks_) {
    if (peers.empty() || peers.back().rank != block.source_rank)
      peers.push_back({world.ranks_of(from)[block.source_rank], from, block.source_rank, {}});
    for (const int point : block.target_points)
      peers.back().points.push_back(first_point[block.target_rank] + point);
  }
  return peers;
}

std::vector<double> RouteTable::target_coordinates() const {
  std::vector<double> all;
  for (const auto &coordinates : target_.coordinates)
    all.insert(all.end(), coordinates.begin(), coordinates.end());
  return all;
}

} // namespace heartbus::bus
