#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace heartbus::mapping {

using Point = std::array<double, 3>;

double distance(const Point &p, const Point &q);

struct Box {
  Point low{}, high{};
  double diameter() const { return distance(low, high); }
};
Box bounding_box(const std::vector<Point> &points);

/// Finds points in a neighbourhood: space is cut into cubes, and the points are sorted by the hash of their cube. Cubes
/// with equal hashes do no harm, since distances decide.
class PointHash {
 public:
  PointHash(const std::vector<Point> &points, double cube_size);
  /// All points within `radius` (less than the cube size) of `p`.
  std::vector<std::size_t> within(const Point &p, double radius) const;

 private:
  std::int64_t cube(double coordinate) const;
  const std::vector<Point> &points_;
  double cube_size_;
  std::vector<std::pair<std::uint64_t, std::size_t>> sorted_; ///< hash of the cube, point
};

} // namespace heartbus::mapping
