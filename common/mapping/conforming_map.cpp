#include "common/mapping/conforming_map.h"

#include "common/base/failure.h"
#include "common/mapping/point_hash.h"

#include <algorithm>
#include <map>
#include <sstream>

namespace heartbus::mapping {
namespace {

std::vector<Point> flatten(const DistributedPoints &points) {
  std::vector<Point> all;
  for (const std::vector<double> &of_rank : points.coordinates)
    for (std::size_t i = 0; i + 2 < of_rank.size(); i += 3)
      all.push_back({of_rank[i], of_rank[i + 1], of_rank[i + 2]});
  return all;
}

std::string text(const Point &p) {
  std::ostringstream out;
  out.precision(10);
  out << "(" << p[0] << ", " << p[1] << ", " << p[2] << ")";
  return out.str();
}

/// Compares the extents of both sets: a mesh in millimetres is a thousand times too large.
std::string diagnosis(const DistributedPoints &source, const std::vector<Point> &sources,
                      const DistributedPoints &target, const std::vector<Point> &targets) {
  const Box a = bounding_box(sources), b = bounding_box(targets);
  std::ostringstream out;
  out << "\n  " << source.name << " spans " << text(a.low) << " to " << text(a.high) << " m, " << target.name
      << " spans " << text(b.low) << " to " << text(b.high) << " m";
  const double small = std::min(a.diameter(), b.diameter()), large = std::max(a.diameter(), b.diameter());
  if (small > 0 && large / small > 500 && large / small < 2000)
    out << "; their sizes differ by " << large / small << ": "
        << (a.diameter() > b.diameter() ? source.name : target.name) << " looks like millimetres given as metres";
  return out.str();
}

[[noreturn]] void refuse(const DistributedPoints &source, const std::vector<Point> &sources,
                         const DistributedPoints &target, const std::vector<Point> &targets,
                         const std::vector<std::size_t> &alone, double tolerance) {
  // The nearest point is searched by brute force, so only for a sample of many failures.
  const std::size_t stride = 1 + alone.size() / 200;
  std::size_t worst = alone.front(), nearest = 0;
  double largest = -1;
  for (std::size_t i = 0; i < alone.size() && !sources.empty(); i += stride) {
    const Point &target_point = targets[alone[i]];
    const auto closer = [&](const Point &p, const Point &q) {
      return distance(p, target_point) < distance(q, target_point);
    };
    const std::size_t candidate = std::min_element(sources.begin(), sources.end(), closer) - sources.begin();
    if (const double d = distance(sources[candidate], target_point); d > largest) {
      largest = d;
      worst = alone[i];
      nearest = candidate;
    }
  }
  std::ostringstream out;
  out << alone.size() << " of " << targets.size() << " points of " << target.name << " have no partner in "
      << source.name << " within " << tolerance << " m; the worst is " << text(targets[worst]);
  if (sources.empty())
    out << ", as " << source.name << " has no points";
  else
    out << ", whose nearest point " << text(sources[nearest]) << " is " << largest << " m away"
        << diagnosis(source, sources, target, targets);
  throw Failure(ExitCode::map, out.str());
}

/// Rank and number within the rank of every point.
std::vector<std::pair<int, int>> owners(const DistributedPoints &points) {
  std::vector<std::pair<int, int>> owner;
  for (std::size_t rank = 0; rank < points.coordinates.size(); ++rank)
    for (std::size_t i = 0; i < points.coordinates[rank].size() / 3; ++i)
      owner.emplace_back(rank, i);
  return owner;
}

} // namespace

std::vector<std::size_t> match_points(const DistributedPoints &source, const DistributedPoints &target) {
  const std::vector<Point> sources = flatten(source), targets = flatten(target);
  const double spacing = std::min(source.spacing, target.spacing);
  if (!(spacing > 0))
    throw Failure(ExitCode::map, "the spacing of " + source.name + " or " + target.name + " is not positive");
  const double tolerance = relative_tolerance * spacing;

  const PointHash hash(sources, spacing);
  std::vector<std::size_t> source_of_target(targets.size()), alone;
  for (std::size_t t = 0; t < targets.size(); ++t) {
    const std::vector<std::size_t> partners = hash.within(targets[t], tolerance);
    if (partners.size() > 1)
      throw Failure(ExitCode::map, "point " + text(targets[t]) + " of " + target.name + " has " +
                                       std::to_string(partners.size()) + " partners in " + source.name +
                                       "; every point must be declared once, by the rank that owns it");
    if (partners.empty())
      alone.push_back(t);
    else
      source_of_target[t] = partners.front();
  }
  if (!alone.empty())
    refuse(source, sources, target, targets, alone, tolerance);
  return source_of_target;
}

std::vector<Block> split_by_ranks(const std::vector<std::size_t> &source_of_target, const DistributedPoints &source,
                                  const DistributedPoints &target) {
  const auto source_owner = owners(source), target_owner = owners(target);
  std::map<std::pair<int, int>, Block> blocks;
  for (std::size_t t = 0; t < source_of_target.size(); ++t) {
    const auto &[source_rank, source_point] = source_owner[source_of_target[t]];
    const auto &[target_rank, target_point] = target_owner[t];
    Block &block = blocks[{source_rank, target_rank}];
    block.source_rank = source_rank;
    block.target_rank = target_rank;
    block.source_points.push_back(source_point);
    block.target_points.push_back(target_point);
  }
  std::vector<Block> sorted;
  for (auto &[ranks, block] : blocks)
    sorted.push_back(std::move(block));
  return sorted;
}

} // namespace heartbus::mapping
