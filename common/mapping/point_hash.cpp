#include "common/mapping/point_hash.h"

#include <algorithm>
#include <cmath>

namespace heartbus::mapping {
namespace {

std::uint64_t hash(std::int64_t i, std::int64_t j, std::int64_t k) {
  std::uint64_t h = 0;
  for (const std::int64_t index : {i, j, k})
    h = (h ^ static_cast<std::uint64_t>(index)) * 0x9e3779b97f4a7c15u + (h >> 29);
  return h;
}

} // namespace

double distance(const Point &p, const Point &q) { return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]); }

Box bounding_box(const std::vector<Point> &points) {
  if (points.empty())
    return {};
  Box box{points.front(), points.front()};
  for (const Point &p : points)
    for (int d = 0; d < 3; ++d) {
      box.low[d] = std::min(box.low[d], p[d]);
      box.high[d] = std::max(box.high[d], p[d]);
    }
  return box;
}

PointHash::PointHash(const std::vector<Point> &points, double cube_size) : points_(points), cube_size_(cube_size) {
  for (std::size_t i = 0; i < points.size(); ++i)
    sorted_.emplace_back(hash(cube(points[i][0]), cube(points[i][1]), cube(points[i][2])), i);
  std::sort(sorted_.begin(), sorted_.end());
}

std::int64_t PointHash::cube(double coordinate) const {
  return static_cast<std::int64_t>(std::floor(coordinate / cube_size_));
}

std::vector<std::size_t> PointHash::within(const Point &p, double radius) const {
  std::vector<std::size_t> found;
  for (std::int64_t i = cube(p[0] - radius); i <= cube(p[0] + radius); ++i)
    for (std::int64_t j = cube(p[1] - radius); j <= cube(p[1] + radius); ++j)
      for (std::int64_t k = cube(p[2] - radius); k <= cube(p[2] + radius); ++k) {
        const std::uint64_t key = hash(i, j, k);
        auto entry = std::lower_bound(sorted_.begin(), sorted_.end(), std::make_pair(key, std::size_t(0)));
        for (; entry != sorted_.end() && entry->first == key; ++entry)
          if (distance(points_[entry->second], p) <= radius)
            found.push_back(entry->second);
      }
  // Cubes with equal hashes may have been visited twice.
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

} // namespace heartbus::mapping
