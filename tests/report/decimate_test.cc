// Thinned lines against brute force: how far any point left out lies from what is left.
#include "impedraw/report/sheet.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

double farthest_off(const Line2d& line, const Line2d& thin) {
  double farthest = 0.0;
  for (const Eigen::Vector2d& p : line) {
    double nearest = (p - thin.front()).norm();
    for (std::size_t i = 0; i + 1 < thin.size(); ++i) {
      double low = 0.0, high = 1.0;  // golden section
      const auto at = [&](double t) { return (p - thin[i] - t * (thin[i + 1] - thin[i])).norm(); };
      for (int k = 0; k < 50; ++k) {
        const double a = high - 0.618033988749895 * (high - low),
                     b = low + 0.618033988749895 * (high - low);
        (at(a) < at(b) ? high : low) = at(a) < at(b) ? b : a;
      }
      nearest = std::min({nearest, at(low), at(0.0), at(1.0)});
    }
    farthest = std::max(farthest, nearest);
  }
  return farthest;
}

TEST(ThinLine, KnownLines) {
  EXPECT_TRUE(decimated({}, 0.1).empty());
  EXPECT_EQ(decimated({{1, 2}}, 0.1), (Line2d{{1, 2}}));
  EXPECT_EQ(decimated({{0, 0}, {1, 0.05}, {2, -0.05}, {3, 0}}, 0.1), (Line2d{{0, 0}, {3, 0}}));
  EXPECT_EQ(decimated({{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}}, 0.1),
            (Line2d{{0, 0}, {2, 0}, {2, 2}}));
  EXPECT_EQ(decimated({{0, 0}, {1, 0}, {2, 0}, {1, 0}, {-1, 0}}, 0.1),
            (Line2d{{0, 0}, {2, 0}, {-1, 0}}));  // there and back: the tip stays
  EXPECT_EQ(decimated({{-1, 0}, {-2, 1e-9}, {-3, -1e-9}, {-4, 1e-9}}, 0.1).size(),
            2u);  // where angles jump by a turn
}

// On a circle of radius r a chord of length c is c²/8r off in the middle.
TEST(ThinLine, ChordsOfACircle) {
  constexpr double kRadius = 5.0, kTolerance = 0.02;
  Line2d circle;
  for (int i = 0; i <= 20000; ++i) {
    const double a = 2 * std::numbers::pi * i / 20000;
    circle.emplace_back(kRadius * std::cos(a), kRadius * std::sin(a));
  }
  const Line2d thin = decimated(circle, kTolerance);
  const double chord = std::sqrt(8 * kRadius * kTolerance);
  EXPECT_NEAR(static_cast<double>(thin.size()),
              1 + std::ceil(2 * std::numbers::pi * kRadius / chord), 1.0);
}

TEST(ThinLine, NothingLeftOutIsFartherThanTheTolerance) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::normal_distribution<double> gauss;
    const double tolerance = 0.05 * (1 + seed % 4), wander = seed % 3 == 0 ? 0.5 : 0.05;
    Line2d line{{0, 0}};
    Eigen::Vector2d step(0.1, 0);
    for (int i = 0; i < 400; ++i) {
      step += wander * 0.1 * Eigen::Vector2d(gauss(random), gauss(random));
      line.push_back(line.back() +
                     (i % 50 == 49 ? -3.0 : 1.0) * step);  // now and then sharply back
      if (i % 40 == 0) line.push_back(line.back());
    }
    const Line2d thin = decimated(line, tolerance);
    EXPECT_EQ(thin.front(), line.front());
    EXPECT_EQ(thin.back(), line.back());
    EXPECT_LE(farthest_off(line, thin), tolerance + 1e-9);
    EXPECT_LT(thin.size(), line.size());
  }
}

TEST(ThinLine, ManyLinesAreThinnedUntilTheyAreFew) {
  std::mt19937 random(1);
  std::normal_distribution<double> gauss;
  std::vector<Line2d> lines;
  for (int k = 0; k < 20; ++k) {
    Line2d& line = lines.emplace_back();
    for (int i = 0; i < 500; ++i) line.emplace_back(0.1 * i, k + 0.1 * gauss(random));
  }
  const std::vector<Line2d> before = lines;
  const double off = decimate_to(lines, 0.02, 1000);
  std::size_t points = 0;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    points += lines[k].size();
    EXPECT_LE(farthest_off(before[k], lines[k]), off + 1e-9);
  }
  EXPECT_LE(points, 1000u);
  EXPECT_LT(off, 1.3);
  EXPECT_GT(off, 0.02);
  EXPECT_NEAR(decimate_to(lines, 1e-6, 1000), 1e-6, 1e-12) << "few enough at once";
}

}  // namespace
}  // namespace impedraw
