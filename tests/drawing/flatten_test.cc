#include "impedraw/drawing/svg_subpaths.h"

#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "lines.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;

Vector2d cubic(const Vector2d* p, double s) {
  const double r = 1 - s;
  return r * r * r * p[0] + 3 * r * r * s * p[1] + 3 * r * s * s * p[2] + s * s * s * p[3];
}

double largest_turn(const std::vector<Vector2d>& line) {
  double largest = 0;
  for (std::size_t i = 2; i < line.size(); ++i) {
    const Vector2d a = line[i - 1] - line[i - 2], b = line[i] - line[i - 1];
    largest = std::max(largest, std::abs(std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b))));
  }
  return largest;
}

TEST(Flatten, RandomCubicsStayWithinTheTolerance) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> coordinate(-100, 100);
    Vector2d p[4];
    for (Vector2d& q : p) q = {coordinate(random), coordinate(random)};
    FlattenSettings settings;
    settings.tolerance = seed % 2 ? 0.01 : 0.5;
    std::vector<Vector2d> line{p[0]};
    flatten_cubic(p[0], p[1], p[2], p[3], settings, line);
    EXPECT_EQ(line.back(), p[3]);
    EXPECT_LE(lines::worst([&](double s) { return cubic(p, s); }, line), settings.tolerance);
    // Every vertex is a point of the curve.
    std::vector<Vector2d> fine;
    for (int i = 0; i <= 20000; ++i) fine.push_back(cubic(p, i / 20000.0));
    for (std::size_t i = 0; i < line.size(); i += 7)
      EXPECT_LT(lines::distance(line[i], fine), 1e-5);
  }
}

TEST(Flatten, QuadraticIsNoFinerThanItNeeds) {
  // A parabola's chord over a parameter step h is off by |P''| h²/8 exactly: 200 mm wide, 50 mm
  // high, 0.01 mm take at least 71 equal chords.
  const Vector2d a(-100, 0), b(0, 100), c(100, 0);
  std::vector<Vector2d> line{a};
  FlattenSettings settings;
  flatten_quadratic(a, b, c, settings, line);
  EXPECT_LE(lines::worst(
                [&](double s) {
                  return Vector2d((1 - s) * (1 - s) * a + 2 * s * (1 - s) * b + s * s * c);
                },
                line),
            0.01);
  EXPECT_GE(line.size(), 71u);
  EXPECT_LE(line.size(), 2 * 71u);
}

TEST(Flatten, SmallCurvesStaySmooth) {
  // A semicircle of 0.05 mm radius is within 0.01 mm of a triangle, yet no corner of it turns by
  // more than the setting.
  const double k = 4.0 / 3.0 * std::tan(std::numbers::pi / 8) * 0.05;
  std::vector<Vector2d> line{{0.05, 0}};
  flatten_cubic({0.05, 0}, {0.05, k}, {k, 0.05}, {0, 0.05}, {}, line);
  flatten_cubic({0, 0.05}, {-k, 0.05}, {-0.05, k}, {-0.05, 0}, {}, line);
  EXPECT_LT(largest_turn(line), 0.2);
}

TEST(Flatten, CuspsAndPointsEnd) {
  std::vector<Vector2d> line{{0, 0}};
  flatten_cubic({0, 0}, {100, 100}, {0, 100}, {100, 0}, {}, line);  // crosses itself
  flatten_cubic({100, 0}, {0, 100}, {100, 100}, {0, 0}, {}, line);
  flatten_cubic({0, 0}, {100, 0}, {-50, 0}, {50, 0}, {}, line);  // turns back on a line
  flatten_cubic({50, 0}, {50, 0}, {50, 0}, {50, 0}, {}, line);
  EXPECT_LT(line.size(), 3000u);
}

TEST(Flatten, ArcOfACubicIsFoundAgain) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> coordinate(-100, 100);
    std::uniform_real_distribution<double> turn(0.1, std::numbers::pi / 2);
    const auto point = [&] { return Vector2d(coordinate(random), coordinate(random)); };
    const EllipseArc arc{point(), point(), point(), turn(random)};
    const double k = 4.0 / 3.0 * std::tan(arc.angle / 4);
    const Vector2d d = arc.at(arc.angle);
    const Vector2d v_end = -std::sin(arc.angle) * arc.u + std::cos(arc.angle) * arc.v;
    const EllipseArc found = arc_of_cubic(arc.at(0), arc.at(0) + k * arc.v, d - k * v_end, d);
    if (std::abs(arc.u.x() * arc.v.y() - arc.u.y() * arc.v.x()) < 1.0) continue;
    EXPECT_NEAR(found.angle, arc.angle, 1e-6);
    EXPECT_LT((found.centre - arc.centre).norm(), 1e-4);
    EXPECT_LT((found.u - arc.u).norm(), 1e-4);
  }
  EXPECT_EQ(arc_of_cubic({0, 0}, {0, 40}, {70, 100}, {100, 100}).angle,
            0);  // handles of different length: no such arc
}

}  // namespace
}  // namespace impedraw
