#include "impedraw/drawing/simplify.h"

#include <random>

#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "impedraw/drawing/order.h"
#include "lines.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;

std::vector<Vector2d> random_walk(unsigned seed, int count) {
  std::mt19937 random(seed);
  std::normal_distribution<double> turn(0, seed % 3 ? 0.3 : 2.0);
  std::vector<Vector2d> line{{0, 0}};
  double angle = 0;
  for (int i = 1; i < count; ++i) {
    angle += turn(random);
    line.push_back(line.back() + Vector2d(std::cos(angle), std::sin(angle)));
  }
  return line;
}

// Of points close together along one line to the other.
double farthest(const std::vector<Vector2d>& from, const std::vector<Vector2d>& to) {
  double worst = 0;
  for (std::size_t i = 1; i < from.size(); ++i) {
    for (int k = 0; k <= 10; ++k)
      worst = std::max(worst, lines::distance(from[i - 1] + 0.1 * k * (from[i] - from[i - 1]), to));
  }
  return worst;
}

TEST(Simplify, NeverMovesALineByMoreThanItsTolerance) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    const double tolerance = seed % 2 ? 0.2 : 1.5;
    Stroke stroke{random_walk(seed, 150), false, 3};
    if (seed % 4 == 0) stroke.points.push_back(stroke.points.front()), stroke.closed = true;
    const Stroke simple = simplified(stroke, tolerance);
    EXPECT_LT(simple.points.size(), stroke.points.size());
    EXPECT_EQ(simple.points.front(), stroke.points.front());
    EXPECT_EQ(simple.points.back(), stroke.points.back());
    EXPECT_EQ(simple.closed, stroke.closed);
    EXPECT_EQ(simple.layer, 3);
    EXPECT_LE(farthest(stroke.points, simple.points), tolerance + 1e-9);
    EXPECT_LE(farthest(simple.points, stroke.points), tolerance + 1e-9);
  }
}

TEST(Simplify, WhatIsStraightAndWhatIsSmall) {
  Stroke straight{{}, false, 0};
  for (int i = 0; i <= 100; ++i) straight.points.emplace_back(0.1 * i, 0.2 * i);
  EXPECT_EQ(simplified(straight, 1e-6).points.size(), 2u);
  const Stroke back{{{0, 0}, {10, 0}, {4, 0}}, false, 0};  // beyond its end, on its line
  EXPECT_EQ(simplified(back, 1.0).points, back.points);
  const Stroke small{{{0, 0}, {1, 0}, {1, 1}, {0, 0}}, true, 0};
  EXPECT_EQ(simplified(small, 5.0).points, (std::vector<Vector2d>{{0, 0}, {1, 1}, {0, 0}}));
  EXPECT_EQ(simplified(small, 0).points, small.points);
  EXPECT_THROW(simplified(small, -1), InputError);
}

// Press is even along these: 2 mm up to 3 mm, then rising by 1 mm a mm.
TEST(Simplified, KeepsTheBendsOfTheWidth) {
  Stroke stroke;
  for (int i = 0; i <= 60; ++i) {
    stroke.points.emplace_back(0.1 * i, 0.0);
    stroke.press.push_back(2 + std::max(0.0, 0.1 * i - 3));
  }
  const Stroke less = simplified(stroke, 0.01);
  ASSERT_EQ(less.points.size(), 3u);
  EXPECT_EQ(less.points[1], stroke.points[30]);
  EXPECT_EQ(less.press, (std::vector<double>{2, 2, stroke.press.back()}));
}

}  // namespace
}  // namespace impedraw
