#include "impedraw/drawing/joined.h"

#include <gtest/gtest.h>

#include "impedraw/drawing/order.h"

namespace impedraw {
namespace {

// Four sides of a square, in any order and either way round, are one closed line.
TEST(Joined, SidesOfASquareAreOneLine) {
  const std::vector<Stroke> sides = {
      {{{0, 0}, {9, 0}}}, {{{9, 9}, {9, 0.04}}}, {{{0, 9}, {9, 9}}}, {{{0, 0}, {0, 9}}}};
  const std::vector<Stroke> lines = joined(sides);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NEAR(pen_down_length(lines), 36.0, 1e-9);
}

TEST(Joined, OtherPensGapsAndRingsStayApart) {
  const Stroke first{{{0, 0}, {9, 0}}};
  const auto with = [&](auto change) {
    Stroke next{{{9, 0}, {9, 9}}};
    change(next);
    return joined({first, next}).size();
  };
  EXPECT_EQ(with([](Stroke&) {}), 1u);
  EXPECT_EQ(with([](Stroke& s) { s.layer = 1; }), 2u);
  EXPECT_EQ(with([](Stroke& s) { s.colour = 0xff0000; }), 2u);
  EXPECT_EQ(with([](Stroke& s) { s.width = 2; }), 2u);
  EXPECT_EQ(with([](Stroke& s) { s.points.front().y() = 0.06; }), 2u);
  EXPECT_EQ(with([](Stroke& s) { s.press = {1, 2}; }), 2u);
  EXPECT_EQ(with([](Stroke& s) {
              s.points.push_back({9, 0});
              s.closed = true;
            }),
            2u);
}

TEST(Joined, WeightsGoOnWithTheirPoints) {
  Stroke a{{{0, 0}, {9, 0}}}, b{{{9, 0}, {9, 9}}};
  a.press = {1, 2};
  b.press = {3, 4};
  const std::vector<Stroke> lines = joined({a, b});
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0].press, (std::vector<double>{1, 2, 4}));
  EXPECT_EQ(lines[0].points.size(), 3u);
}

// Of two lines that cross, each goes straight on.
TEST(Joined, TheStraightestGoesOn) {
  const std::vector<Stroke> lines = joined({Stroke{{{0, 5}, {5, 5}}}, Stroke{{{5, 10}, {5, 5}}},
                                            Stroke{{{5, 5}, {10, 5}}}, Stroke{{{5, 5}, {5, 0}}}});
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0].points.back(), Eigen::Vector2d(10, 5));
  EXPECT_EQ(lines[1].points.back(), Eigen::Vector2d(5, 0));
}

}  // namespace
}  // namespace impedraw
