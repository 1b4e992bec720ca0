#include "common/mapping/conforming_map.h"

#include "common/base/failure.h"

#include <gtest/gtest.h>

namespace heartbus::mapping {
namespace {

/// A cube of n x n x n points at distance h, dealt to ranks in turn, every point a little off by `noise`.
DistributedPoints cube(const std::string &name, int n, double h, int n_ranks, double noise = 0) {
  DistributedPoints points{name, std::vector<std::vector<double>>(n_ranks), h};
  for (int i = 0; i < n * n * n; ++i) {
    auto &mine = points.coordinates[(7 * i) % n_ranks];
    for (const int c : {i % n, i / n % n, i / n / n})
      mine.push_back(h * c + noise * (i % 2 ? 1 : -1));
  }
  return points;
}

std::string refusal(const DistributedPoints &source, const DistributedPoints &target) {
  try {
    match_points(source, target);
  } catch (const Failure &failure) {
    EXPECT_EQ(failure.code(), ExitCode::map);
    return failure.what();
  }
  return "";
}

bool contains(const std::string &text, const std::string &part) { return text.find(part) != std::string::npos; }

/// Carries the x coordinate along a map and compares it at the target.
void expect_coordinates_arrive(const DistributedPoints &source, const DistributedPoints &target) {
  const auto blocks = split_by_ranks(match_points(source, target), source, target);
  std::size_t n_arrived = 0, n_targets = 0;
  for (const Block &block : blocks)
    for (std::size_t i = 0; i < block.target_points.size(); ++i, ++n_arrived)
      for (int d = 0; d < 3; ++d)
        EXPECT_NEAR(source.coordinates[block.source_rank][3 * block.source_points[i] + d],
                    target.coordinates[block.target_rank][3 * block.target_points[i] + d], 1e-12);
  for (const auto &of_rank : target.coordinates)
    n_targets += of_rank.size() / 3;
  EXPECT_EQ(n_arrived, n_targets);
}

TEST(ConformingMap, EveryTargetFindsItsSourceOnAnyNumberOfRanks) {
  expect_coordinates_arrive(cube("a", 6, 0.01, 2), cube("b", 6, 0.01, 3, 1e-13));
}

TEST(ConformingMap, NestedMeshesLeaveTheFinerPointsOut) {
  expect_coordinates_arrive(cube("fine", 9, 0.005, 3), cube("coarse", 5, 0.01, 2));
}

TEST(ConformingMap, PointsNearTheFaceOfACubeOfTheHashAreFound) {
  DistributedPoints a{"a", {{-1e-10, 0.01 - 1e-10, 0.}}, 0.01}, b{"b", {{1e-10, 0.01 + 1e-10, 0.}}, 0.01};
  EXPECT_EQ(match_points(a, b), std::vector<std::size_t>{0});
}

TEST(ConformingMap, ARankWithoutPointsIsNoProblem) {
  auto target = cube("b", 3, 0.01, 2);
  target.coordinates.insert(target.coordinates.begin(), std::vector<double>());
  expect_coordinates_arrive(cube("a", 3, 0.01, 2), target);
}

TEST(ConformingMap, AMismatchNamesTheWorstPointAndItsNeighbour) {
  auto target = cube("b", 3, 0.01, 1);
  target.coordinates[0][3] += 0.001;
  target.coordinates[0][6] += 0.002;
  const std::string message = refusal(cube("a", 3, 0.01, 2), target);
  EXPECT_TRUE(contains(message, "2 of 27 points of b have no partner in a")) << message;
  EXPECT_TRUE(contains(message, "the worst is (0.022, 0, 0), whose nearest point (0.02, 0, 0) is 0.002 m away"))
      << message;
  EXPECT_FALSE(contains(message, "millimetres")) << message;
}

TEST(ConformingMap, ASlipOfUnitsIsRecognised) {
  EXPECT_TRUE(contains(refusal(cube("a", 3, 10., 1), cube("b", 3, 0.01, 1)), "a looks like millimetres"));
}

TEST(ConformingMap, APointDeclaredByTwoRanksIsRefused) {
  auto source = cube("a", 3, 0.01, 1);
  source.coordinates.push_back({0.02, 0.02, 0.02});
  EXPECT_TRUE(contains(refusal(source, cube("b", 3, 0.01, 1)), "has 2 partners"));
}

} // namespace
} // namespace heartbus::mapping
