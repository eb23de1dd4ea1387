// What lies on itself is drawn once, against lengths in closed form.
#include "impedraw/drawing/doubles.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "impedraw/drawing/order.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;

std::vector<Vector2d> circle(double radius, double from, double to, int points) {
  std::vector<Vector2d> line;
  for (int i = 0; i <= points; ++i) {
    const double a = from + (to - from) * i / points;
    line.push_back(radius * Vector2d(std::cos(a), std::sin(a)));
  }
  return line;
}

TEST(Doubles, SharedEdgesAreDrawnOnce) {
  std::vector<Stroke> strokes = {{{{10, 10}, {50, 10}, {50, 50}, {10, 50}, {10, 10}}, true},
                                 {{{50, 10}, {90, 10}, {90, 50}, {50, 50}, {50, 10}}, true},
                                 {{{10.0, 10.05}, {50, 10.05}}}};
  EXPECT_NEAR(drop_doubles(strokes, 0.1), 80, 1e-9);
  EXPECT_NEAR(pen_down_length(strokes), 280, 1e-9);
  EXPECT_EQ(strokes.size(), 2u);
  EXPECT_TRUE(strokes[0].closed);
  EXPECT_NEAR(drop_doubles(strokes, 0.1), 0, 1e-9);
}

TEST(Doubles, CurvesAndRetracedLines) {
  const double pi = std::numbers::pi;
  std::vector<Stroke> strokes = {{circle(30, 0, 2 * pi, 700), true}, {circle(30, 4, 1, 333)}};
  EXPECT_NEAR(drop_doubles(strokes, 0.05), 90, 0.05);
  EXPECT_EQ(strokes.size(), 1u);
  strokes = {{{{0, 0}, {40, 0}, {10, 0}}}};
  EXPECT_NEAR(drop_doubles(strokes, 0.1), 30, 1e-9);
}

// Each lies on the one before: what is removed hides nothing.
TEST(Doubles, WhatIsRemovedRemovesNothing) {
  std::vector<Stroke> strokes;
  for (int i = 0; i < 20; ++i) strokes.push_back({{{0, 0.08 * i}, {40 + 0.5 * i, 0.08 * i}}});
  drop_doubles(strokes, 0.1);
  for (int i = 0; i < 20; ++i) {
    double nearest = 1;
    for (const Stroke& s : strokes) {
      if (std::min(s.points.front().x(), s.points.back().x()) < 1)
        nearest = std::min(nearest, std::abs(s.points.front().y() - 0.08 * i));
    }
    EXPECT_LT(nearest, 0.1) << i;
  }
}

TEST(Doubles, WhatOnlyCrossesOrLiesApartStays) {
  std::vector<Stroke> strokes = {{{{0, 0}, {40, 0}}},
                                 {{{20, -20}, {20, 20}}},
                                 {{{0, -0.5}, {40, 0.5}}},  // at 1.4°, within for 8 mm
                                 {{{0, 0.3}, {40, 0.3}}},
                                 {{{0, 0}, {40, 0}}, false, 1}};  // another pen
  EXPECT_NEAR(drop_doubles(strokes, 0.1), 0, 1e-9);
  EXPECT_EQ(strokes.size(), 5u);
}

}  // namespace
}  // namespace impedraw
