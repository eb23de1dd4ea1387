#include "impedraw/ink/segments.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

using Line = std::vector<Eigen::Vector3d>;

Line straight(double from, double to, double step, double y = 0.0) {
  Line line;
  const int n = static_cast<int>(std::round((to - from) / step));
  for (int i = 0; i <= n; ++i) line.emplace_back(from + i * step, y, 0.0);
  return line;
}

TEST(WithinReach, BallAtEachEndAndTubeBetween) {
  const Segment s{{-10, 0, 0}, {10, 0, 0}};
  const auto expect = [&](const Segment& ink, double first, double second) {
    const auto [a, b] = within_reach(s, ink, 1.0);
    EXPECT_NEAR(a, first, 1e-12);
    EXPECT_NEAR(b, second, 1e-12);
  };
  expect({{0, 0, 0}, {0, 0, 0}}, 9, 11);                                       // a dot on the line
  expect({{0, 0.6, 0}, {0, 0.6, 0}}, 9.2, 10.8);                               // beside it
  expect({{0, 0.6, 0}, {2, 0.6, 0}}, 9.2, 12.8);                               // parallel
  expect({{0, -5, 0}, {0, 5, 0}}, 9, 11);                                      // across
  expect({{0, 0.6, -5}, {0, 0.6, 5}}, 9.2, 10.8);                              // across, passing by
  expect({{-5, -5, 0}, {5, 5, 0}}, 10 - std::sqrt(2.0), 10 + std::sqrt(2.0));  // at a slant
  expect({{9.5, 0, 0}, {30, 0, 0}}, 18.5, 20);  // clipped to the segment
  const auto [a, b] = within_reach(s, {{0, 1.1, -5}, {0, 1.1, 5}}, 1.0);
  EXPECT_GT(a, b);
}

TEST(Cover, HalfTheLineWithAGapOfKnownLength) {
  const Line target = straight(0, 100, 0.4);
  const std::vector<Line> ink{straight(0, 30, 0.05, 0.3), straight(50, 90, 0.05, 0.3)};
  const Coverage c = cover(target, Segments(ink, 0.25), 0.5);
  // Beside an end of the ink at 0.3 the target is within 0.5 for another 0.4.
  EXPECT_NEAR(c.length, 100.0, 1e-9);
  EXPECT_NEAR(c.covered, 30.4 + 40.8, 1e-9);
  ASSERT_EQ(c.uncovered_spans.size(), 2u);
  EXPECT_NEAR(c.uncovered_spans[0], 19.2, 1e-9);
  EXPECT_NEAR(c.uncovered_spans[1], 9.6, 1e-9);
}

TEST(Cover, NoInkOrInkOutOfReach) {
  const Line target = straight(0, 10, 0.5);
  for (const auto& ink : {std::vector<Line>{}, std::vector<Line>{straight(0, 10, 0.05, 0.51)}}) {
    const Coverage c = cover(target, Segments(ink, 0.25), 0.5);
    EXPECT_EQ(c.covered, 0.0);
    ASSERT_EQ(c.uncovered_spans.size(), 1u);
    EXPECT_NEAR(c.uncovered_spans[0], 10.0, 1e-12);
  }
  EXPECT_EQ(cover({{1, 1, 1}}, Segments(std::vector<Line>{}, 0.25), 0.5).length, 0.0);
}

TEST(Cover, AGapAcrossTheJointOfAClosedTargetIsOne) {
  Line square;
  for (const auto& [x, y] : {std::pair{0, 0}, {10, 0}, {10, 10}, {0, 10}, {0, 0}})
    square.emplace_back(x, y, 0);
  const std::vector<Line> ink{{{3, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 10, 0}, {0, 4, 0}}};
  const Coverage c = cover(square, Segments(ink, 0.25), 0.5);
  ASSERT_EQ(c.uncovered_spans.size(), 1u);
  EXPECT_NEAR(c.uncovered_spans[0], 2.5 + 3.5, 1e-9);
}

TEST(Cover, IsThatOfBruteForceOnWanderingInk) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::normal_distribution<double> gauss;
    Line target, ink{Eigen::Vector3d(0, 0.4, 0)};
    for (int i = 0; i <= 100; ++i)
      target.emplace_back(0.3 * i, std::sin(0.1 * i), std::cos(0.05 * i) - 1);
    while (ink.size() < 700) {
      const Eigen::Vector3d pull = target[std::min<std::size_t>(ink.size() / 7, 100)] - ink.back();
      Eigen::Vector3d step;  // one by one: compilers differ in the order of arguments
      for (const int axis : {2, 1, 0}) step[axis] = gauss(random);
      ink.push_back(ink.back() + 0.08 * step + 0.1 * pull);
    }
    const std::vector<Line> lines{Line(ink.begin(), ink.begin() + 300),
                                  Line(ink.begin() + 350, ink.end())};
    const Coverage c = cover(target, Segments(lines, 0.25), 0.5);
    // Points every 0.003 along the target against every segment of ink.
    double length = 0.0, covered = 0.0, uncovered = 0.0;
    for (std::size_t i = 0; i + 1 < target.size(); ++i) {
      const double piece = (target[i + 1] - target[i]).norm();
      length += piece;
      for (int k = 0; k < 100; ++k) {
        const Eigen::Vector3d p = target[i] + (k + 0.5) / 100 * (target[i + 1] - target[i]);
        bool hit = false;
        for (const Line& line : lines) {
          for (std::size_t m = 0; m + 1 < line.size() && !hit; ++m)
            hit = distance_to_segment(p, {line[m], line[m + 1]}) <= 0.5;
        }
        covered += hit * piece / 100;
      }
    }
    for (const double span : c.uncovered_spans) uncovered += span;
    EXPECT_NEAR(c.length, length, 1e-9);
    EXPECT_NEAR(c.covered, covered, 0.05);
    EXPECT_NEAR(c.covered + uncovered, length, 1e-9);
    EXPECT_GT(covered, 1.0) << "the test would see nothing";
    EXPECT_LT(covered, length - 1.0);
  }
}

}  // namespace
}  // namespace impedraw
