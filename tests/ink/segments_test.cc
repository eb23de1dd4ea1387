#include "impedraw/ink/segments.h"

#include <limits>
#include <random>
#include <set>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

using Line = std::vector<Eigen::Vector3d>;

// A line of pieces from 0.01 to 5 in length, some of them zero.
Line random_line(std::mt19937& random, int points) {
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> decade(-2.0, 0.7);
  Line line{Eigen::Vector3d(gauss(random), gauss(random), gauss(random))};
  while (static_cast<int>(line.size()) < points) {
    const Eigen::Vector3d direction =
        Eigen::Vector3d(gauss(random), gauss(random), gauss(random)).normalized();
    line.push_back(line.back() +
                   (line.size() % 17 == 0 ? 0.0 : std::pow(10.0, decade(random))) * direction);
  }
  return line;
}

// Distance by golden-section search along each segment: nothing in common with the projection
// formula.
double brute_distance(const Eigen::Vector3d& p, const std::vector<Line>& lines) {
  double best = std::numeric_limits<double>::infinity();
  for (const Line& line : lines) {
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      double low = 0.0, high = 1.0;
      const auto at = [&](double t) { return (p - line[i] - t * (line[i + 1] - line[i])).norm(); };
      for (int k = 0; k < 60; ++k) {
        const double a = high - 0.618033988749895 * (high - low),
                     b = low + 0.618033988749895 * (high - low);
        (at(a) < at(b) ? high : low) = at(a) < at(b) ? b : a;
      }
      best = std::min({best, at(0.5 * (low + high)), at(0.0), at(1.0)});
    }
    if (line.size() == 1) best = std::min(best, (p - line[0]).norm());
  }
  return best;
}

TEST(Segments, DistanceIsThatOfBruteForce) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::normal_distribution<double> gauss(0.0, 4.0);
    const std::vector<Line> lines{random_line(random, 60), random_line(random, 1),
                                  random_line(random, 40)};
    const Segments segments(lines, seed % 2 ? 0.25 : 1.0);
    for (int k = 0; k < 60; ++k) {
      Eigen::Vector3d p(gauss(random), gauss(random), gauss(random));
      if (k % 3 == 0) p = lines[0][k % 60] + 0.01 * p;  // near, as ink is
      EXPECT_NEAR(segments.distance(p), brute_distance(p, lines), 1e-7);
    }
  }
}

TEST(Segments, VisitNearMissesNone) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const std::vector<Line> lines{random_line(random, 200)};
    const Segments segments(lines, 0.25);
    for (int k = 0; k < 20; ++k) {
      const Eigen::Vector3d p = lines[0][random() % 200] + Eigen::Vector3d(0.1, 0.2, -0.1);
      const double reach = 0.3 * (k % 5 + 1);
      std::set<std::pair<double, double>> visited;
      segments.visit_near(p, reach, [&](const Segment& s) { visited.emplace(s.a.x(), s.b.x()); });
      for (std::size_t i = 0; i + 1 < lines[0].size(); ++i) {
        const Line piece{lines[0][i], lines[0][i + 1]};
        if (brute_distance(p, {piece}) < reach - 1e-6) {
          EXPECT_TRUE(visited.contains({piece[0].x(), piece[1].x()})) << i;
        }
      }
    }
  }
}

TEST(Segments, KnownDistances) {
  const std::vector<Line> lines{{{0, 0, 0}, {10, 0, 0}}, {{20, 0, 0}}};
  const Segments segments(lines, 0.25);
  EXPECT_DOUBLE_EQ(segments.distance({5.1, 3, 4}), 5.0);
  EXPECT_DOUBLE_EQ(segments.distance({-3, 4, 0}), 5.0);
  EXPECT_DOUBLE_EQ(segments.distance({20, 0, 2}), 2.0);
  EXPECT_TRUE(std::isinf(Segments(std::span<const Line>(), 0.25).distance({0, 0, 0})));
}

}  // namespace
}  // namespace impedraw
