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

TEST(Join, APolylineCutToPiecesComesBack) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(seed);
    const std::vector<Vector2d> line = random_walk(3 * seed + 1, 60);
    std::mt19937 random(seed);
    std::vector<Stroke> pieces;
    for (std::size_t from = 0; from + 1 < line.size();) {
      const std::size_t to = std::min(line.size() - 1, from + 1 + random() % 7);
      pieces.push_back({{line.begin() + from, line.begin() + to + 1}, false, 0});
      if (random() % 2) std::reverse(pieces.back().points.begin(), pieces.back().points.end());
      from = to;
    }
    std::shuffle(pieces.begin(), pieces.end(), random);
    auto whole = joined(pieces, 0);
    ASSERT_EQ(whole.size(), 1u);
    if (whole[0].points.front() != line.front())
      std::reverse(whole[0].points.begin(), whole[0].points.end());
    EXPECT_EQ(whole[0].points, line);
  }
}

TEST(Join, OnlyWithinTheGapAndTheLayer) {
  const std::vector<Stroke> strokes{{{{0, 0}, {1, 0}}, false, 0},
                                    {{{1.2, 0}, {2, 0}}, false, 0},
                                    {{{2, 0}, {3, 0}}, false, 1},
                                    {{{2, 0}}, false, 0},
                                    {{{2, 0}, {2, 1}, {2, 0}}, true, 0}};
  EXPECT_EQ(joined(strokes, 0.1).size(), 5u);
  const auto near = joined(strokes, 0.25);
  ASSERT_EQ(near.size(), 4u);
  EXPECT_EQ(near[0].points, (std::vector<Vector2d>{{0, 0}, {1, 0}, {1.2, 0}, {2, 0}}));
  // Four sides of a square: one closed stroke.
  const std::vector<Vector2d> c{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  std::vector<Stroke> sides;
  for (int i = 0; i < 4; ++i) sides.push_back({{c[i], c[(i + 1) % 4]}, false, 0});
  const auto square = joined(sides, 0.01);
  ASSERT_EQ(square.size(), 1u);
  EXPECT_TRUE(square[0].closed);
  EXPECT_NEAR(pen_down_length(square), 4, 1e-12);
  EXPECT_THROW(joined(sides, std::nan("")), InputError);
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

TEST(Joined, KeepsEachPartsWidths) {
  Stroke thin{{{0, 0}, {1, 0}}}, thick{{{3, 0}, {1, 0}}};
  thin.width = 1;
  thick.width = 2;
  const std::vector<Stroke> one = joined({thin, thick}, 0.1);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one[0].points.size(), 3u);
  EXPECT_EQ(one[0].press, (std::vector<double>{1, 1, 2}));
  thick.width = 1;
  EXPECT_TRUE(joined({thin, thick}, 0.1).at(0).press.empty());
  thick.press = {3, 4};
  EXPECT_EQ(joined({thin, thick}, 0.1).at(0).press, (std::vector<double>{1, 1, 3}));
  thick.by_force = true;
  EXPECT_EQ(joined({thin, thick}, 0.1).size(), 2u);
}

}  // namespace
}  // namespace impedraw
