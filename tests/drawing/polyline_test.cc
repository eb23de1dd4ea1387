#include "impedraw/drawing/polyline.h"

#include <random>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

using Eigen::Vector2d;

TEST(Polyline, DistanceToItsParts) {
  const std::vector<Vector2d> line{{0, 0}, {2, 0}, {2, 3}, {2, 3}, {5, 3}};
  EXPECT_DOUBLE_EQ(length(line), 8);
  EXPECT_DOUBLE_EQ(distance({1, 1}, line, 0, 1), 1);
  EXPECT_DOUBLE_EQ(distance({1, 2}, line, 0, 4), 1);
  EXPECT_DOUBLE_EQ(distance({1, 2}, line, 0, 1), 2);
  EXPECT_DOUBLE_EQ(distance({9, 0}, line, 0, 4), 5);
}

TEST(Polyline, SimplifiedStaysWithinTheTolerance) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-1, 1);
    std::vector<Vector2d> line{{0, 0}};
    for (int i = 0; i < 400; ++i) line.push_back(line.back() + Vector2d(any(random), any(random)));
    const double tolerance = 0.5;
    std::vector<Vector2d> left;
    for (std::size_t i : simplified(line, tolerance)) left.push_back(line[i]);
    EXPECT_LT(left.size(), line.size());
    EXPECT_EQ(left.front(), line.front());
    EXPECT_EQ(left.back(), line.back());
    for (const Vector2d& p : line) EXPECT_LE(distance(p, left, 0, left.size() - 1), tolerance);
  }
}

TEST(Polyline, CornersAreTurnsAboveTheAngle) {
  const std::vector<Vector2d> line{{0, 0}, {1, 0}, {2, 0.1}, {3, 0.2}, {3, 1}, {2.9, 0.1}};
  EXPECT_EQ(corners(line, 0.4), (std::vector<std::size_t>{3, 4}));
  EXPECT_EQ(corners(line, 0.05), (std::vector<std::size_t>{1, 3, 4}));
}

}  // namespace
}  // namespace impedraw
