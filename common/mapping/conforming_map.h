#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace heartbus::mapping {

/// Points of one participant: three coordinates each [m], by the rank that owns them.
struct DistributedPoints {
  std::string name; ///< for messages, e.g. "ep.tissue"
  std::vector<std::vector<double>> coordinates;
  double spacing = 0; ///< distance between neighbours [m]
};

/// Points match when they are closer than this times the smaller spacing of the two sets.
constexpr double relative_tolerance = 1e-6;

/// For every target point the one source point at the same place: what two meshes that share nodes need, nested meshes
/// and P1 nodes within P2 nodes included. Source points without a target are left out. Points count through the ranks.
/// Failure(map) when a target has no or two partners: names the worst one and what the mismatch looks like.
std::vector<std::size_t> match_points(const DistributedPoints &source, const DistributedPoints &target);

/// What one source rank sends to one target rank, in the order of the message.
struct Block {
  int source_rank = 0, target_rank = 0;
  std::vector<int> source_points, target_points; ///< numbered within their rank
};

/// Cuts a map (from match_points) into one block for each pair of ranks that share points, sorted by source, then
/// target.
std::vector<Block> split_by_ranks(const std::vector<std::size_t> &source_of_target, const DistributedPoints &source,
                                  const DistributedPoints &target);

} // namespace heartbus::mapping
