// Where a stroke is cut on surfaces in closed form.
#include "impedraw/planning/preflight/surface_walk.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "planning/surfaces.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kDegree = std::numbers::pi / 180;

SurfaceSample level(double x, double y, double z) { return {{x, y, z}, Vector3d::UnitZ()}; }

// A plane with a round hole about (0.6, 0).
SurfaceHeight holed(double radius) {
  return [radius](double x, double y) -> std::optional<SurfaceSample> {
    if (std::hypot(x - 0.6, y) < radius) return std::nullopt;
    return level(x, y, 0.1);
  };
}

// Level at 0.1 up to x = 0.6, and on the other side at 0.1 + step behind a ramp of the given width.
SurfaceHeight stepped(double step, double width) {
  return [step, width](double x, double y) -> std::optional<SurfaceSample> {
    if (x < 0.6) return level(x, y, 0.1);
    if (x >= 0.6 + width) return level(x, y, 0.1 + step);
    return SurfaceSample{{x, y, 0.1 + step * (x - 0.6) / width},
                         Vector3d(-step / width, 0, 1).normalized()};
  };
}

std::vector<Problem> problems(const std::vector<SurfaceSpan>& spans) {
  std::vector<Problem> found;
  for (const SurfaceSpan& span : spans) {
    if (span.problem) found.push_back(*span.problem);
  }
  return found;
}

// Estimated from few points, the normals on a steep wall lean less than the wall.
TEST(SurfaceWalk, AWallIsAsSteepAsItsHeights) {
  const double wall_deg = 80, estimated_deg = 70, rise = 0.02,
               run = rise / std::tan(wall_deg * kDegree);
  const SurfaceHeight surface = [&](double x, double y) -> std::optional<SurfaceSample> {
    const double z = 0.1 + std::clamp((x - 0.6) / run, 0.0, 1.0) * rise;
    const bool on_wall = x > 0.6 - 1e-3 && x < 0.6 + run + 1e-3;
    const double lean = on_wall ? estimated_deg * kDegree : 0.0;
    return SurfaceSample{{x, y, z}, Vector3d(-std::sin(lean), 0, std::cos(lean))};
  };
  PreflightSettings settings;
  settings.max_slope_deg = 75;
  const auto spans = walk_surface(surfaces::line({{0.55, 0}, {0.65, 0}}), surface, settings);
  for (const SurfaceSpan& span : spans) {
    if (span.problem) continue;
    for (const SurfaceSample& sample : span.samples)
      EXPECT_FALSE(sample.p_P.z() > 0.102 && sample.p_P.z() < 0.118) << sample.p_P.transpose();
  }
  EXPECT_THAT(problems(spans), testing::Contains(Problem::too_steep));
  settings.max_slope_deg = 85;
  EXPECT_TRUE(
      problems(walk_surface(surfaces::line({{0.55, 0}, {0.65, 0}}), surface, settings)).empty());
}

TEST(SurfaceWalk, KeepsItsMarginFromAHole) {
  PreflightSettings settings;
  for (const double margin : {0.0007, 0.003, 0.012}) {
    settings.edge_margin = margin;
    const auto spans = walk_surface(surfaces::line({{0.50, 0}, {0.70, 0}}), holed(0.03), settings);
    ASSERT_EQ(spans.size(), 3u);
    EXPECT_NEAR(spans[0].to, 0.07 - margin, settings.edge_tolerance + 2e-6);
    EXPECT_EQ(spans[0].along.back(), spans[0].to);
    EXPECT_EQ(spans[0].from, 0.0) << "a stroke's own end is no edge";
    EXPECT_NEAR(spans[2].from, 0.13 + margin, settings.edge_tolerance + 2e-6);
    EXPECT_NEAR(spans[2].samples.front().p_P.x(), 0.5 + spans[2].from, 1e-9);
    EXPECT_EQ(spans[1].from, spans[0].to);
    EXPECT_EQ(spans[1].to, spans[2].from);
  }
}

TEST(SurfaceWalk, CutsAHoleOutWhereItsChordIs) {
  PreflightSettings settings;
  settings.edge_margin = 0;
  for (double y : {0.0, 0.01, 0.029}) {
    const auto spans = walk_surface(surfaces::line({{0.50, y}, {0.70, y}}), holed(0.03), settings);
    ASSERT_EQ(spans.size(), 3u);
    ASSERT_EQ(spans[1].problem, Problem::off_canvas);
    const double half = std::sqrt(0.03 * 0.03 - y * y);
    EXPECT_LE(spans[1].from, 0.1 - half);  // on the good side …
    EXPECT_GE(spans[1].to, 0.1 + half);
    EXPECT_NEAR(spans[1].from, 0.1 - half, settings.edge_tolerance + 2e-6);  // … and near it
    EXPECT_NEAR(spans[1].to, 0.1 + half, settings.edge_tolerance + 2e-6);
    EXPECT_NEAR(spans[1].worst, 0.1, 1e-4);
    const double off = std::atof(spans[1].text.c_str());
    EXPECT_NEAR(off, 1e3 * (0.03 - y), 0.2) << spans[1].text;
  }
}

TEST(SurfaceWalk, EndsOnTheGoodSideCanBePlannedFrom) {
  const auto surface = holed(0.03);
  std::mt19937 rng(5);
  SCOPED_TRACE("seed 5");
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const PlacedStroke stroke = surfaces::line({{0.6 + 0.05 * unit(rng), 0.05 * unit(rng)},
                                                {0.6 + 0.05 * unit(rng), 0.05 * unit(rng)},
                                                {0.6 + 0.05 * unit(rng), 0.05 * unit(rng)}});
    for (const SurfaceSpan& span : walk_surface(stroke, surface, {})) {
      if (span.problem) continue;
      for (const Vector2d& p : part_of(stroke, span.from, span.to).p_P)
        EXPECT_TRUE(surface(p.x(), p.y()));
    }
  }
}

TEST(SurfaceWalk, EndsStayClearOfAnEdgeThatASampleFallsOn) {
  const SurfaceHeight half = [](double x, double y) -> std::optional<SurfaceSample> {
    if (x > 0.6) return std::nullopt;
    return level(x, y, 0.1);
  };
  for (int i = 1; i < 200; ++i) {
    const PlacedStroke stroke = surfaces::line(
        {{0.6 - 1e-3 * i, 0.001 * i}, {0.6 - 0.5e-3 * i, 0}, {0.6 + 1e-3 * i, 0.003 * i}});
    const auto spans = walk_surface(stroke, half, {});
    ASSERT_EQ(spans.size(), 2u);
    for (const Vector2d& p : part_of(stroke, spans[0].from, spans[0].to).p_P)
      EXPECT_TRUE(half(p.x(), p.y())) << i;
    const PlacedStroke back = surfaces::line({stroke.p_P[2], stroke.p_P[1], stroke.p_P[0]});
    const auto reversed = walk_surface(back, half, {});
    ASSERT_EQ(reversed.size(), 2u);
    for (const Vector2d& p : part_of(back, reversed[1].from, reversed[1].to).p_P)
      EXPECT_TRUE(half(p.x(), p.y())) << i;
  }
}

TEST(SurfaceWalk, FindsTheFoldAndKeepsBothSides) {
  for (double step : {0.012, -0.012, 0.0007}) {
    const auto spans = walk_surface(surfaces::line({{0.55, 0}, {0.65, 0.0}}), stepped(step, 0), {});
    ASSERT_EQ(spans.size(), 3u);
    EXPECT_EQ(spans[1].problem, Problem::fold);
    // The pen keeps off a step that it cannot ride over, on both sides.
    const double margin = std::abs(step) > 1e-3 ? 4e-3 : 0.0;
    EXPECT_NEAR(spans[1].to - spans[1].from, 2.0 * margin, 2e-5);
    EXPECT_LT(spans[1].from, 0.05);
    EXPECT_GT(spans[1].to, 0.05);
    EXPECT_DOUBLE_EQ(spans[0].samples.back().p_P.z(), 0.1);
    EXPECT_DOUBLE_EQ(spans[2].samples.front().p_P.z(), 0.1 + step);
  }
  EXPECT_EQ(walk_surface(surfaces::line({{0.55, 0}, {0.65, 0}}), stepped(0.0004, 0), {}).size(), 1u)
      << "a step that the tip rides over";
}

TEST(SurfaceWalk, ASteepRampIsNoFold) {
  PreflightSettings settings;
  settings.edge_margin = 0;
  const auto steep = walk_surface(surfaces::line({{0.5503, 0}, {0.65, 0}}), stepped(0.004, 0.0007),
                                  settings);  // 80°, narrower than a step
  ASSERT_EQ(problems(steep), std::vector{Problem::too_steep});
  EXPECT_NEAR(steep[1].to - steep[1].from, 0.0007, 2.1e-4);
  EXPECT_NEAR(steep[1].slope, std::atan2(0.004, 0.0007), 1e-9);
  EXPECT_EQ(steep[1].text, "slope 80°, allowed 75°");
  EXPECT_TRUE(
      problems(walk_surface(surfaces::line({{0.5503, 0}, {0.65, 0}}), stepped(0.002, 0.0007), {}))
          .empty());  // 71°
}

// Beside a steep place the pen would slip down it: with an error of 0.1 mm, by several millimetres.
TEST(SurfaceWalk, KeepsItsMarginFromASteepPlace) {
  PreflightSettings settings;
  settings.edge_margin = 0.002;
  const auto spans =
      walk_surface(surfaces::line({{0.55, 0}, {0.65, 0}}), stepped(0.02, 0.004), settings);
  ASSERT_EQ(spans.size(), 3u);
  EXPECT_EQ(spans[1].problem, Problem::too_steep);
  EXPECT_NEAR(spans[0].to, 0.05 - 0.002, settings.edge_tolerance + 2e-6);
  EXPECT_NEAR(spans[2].from, 0.054 + 0.002, settings.edge_tolerance + 2e-6);
}

// A cloud's wall of 79° ended 4 mm above the ground, and the stroke went on at its foot.
TEST(SurfaceWalk, AStepAtTheFootOfASteepPlaceIsAFold) {
  const SurfaceHeight surface = [](double x, double y) -> std::optional<SurfaceSample> {
    if (x < 0.6) return level(x, y, 0.1);
    if (x > 0.601) return level(x, y, 0.109);
    return SurfaceSample{{x, y, 0.104 + 5.0 * (x - 0.6)}, Vector3d(-5.0, 0, 1).normalized()};
  };
  const auto spans = walk_surface(surfaces::line({{0.55, 0}, {0.65, 0}}), surface, {});
  EXPECT_THAT(problems(spans), testing::Contains(Problem::fold));
  EXPECT_THAT(problems(spans), testing::Contains(Problem::too_steep));
  ASSERT_FALSE(spans[0].problem);
  EXPECT_NEAR(spans[0].to, 0.05 - 0.004, 1e-4) << "off the wall by its height, up to 4 mm";
}

TEST(SurfaceWalk, TheSteepestSlopeKnownCounts) {
  const SurfaceHeight surface = [](double x, double y) -> std::optional<SurfaceSample> {
    SurfaceSample sample{{x, y, 0.1 + 2.0 * x}, Vector3d(-2.0, 0, 1).normalized()};  // 63°
    if (x > 0.6) sample.steepest = std::cos(80 * kDegree);
    return sample;
  };
  const auto spans = walk_surface(surfaces::line({{0.55, 0}, {0.65, 0}}), surface, {});
  ASSERT_EQ(problems(spans), std::vector{Problem::too_steep});
  EXPECT_LE(spans[0].to, 0.05);
  EXPECT_NEAR(spans[1].slope, 80 * kDegree, 1e-9);
}

TEST(SurfaceWalk, CutsTheBowlWhereItReachesTheSlope) {
  PreflightSettings settings;
  settings.edge_margin = 0;
  settings.max_slope_deg = 25;
  const auto spans = walk_surface(surfaces::line({{0.6, 0}, {0.77, 0}}), surfaces::bowl, settings);
  ASSERT_EQ(problems(spans), std::vector{Problem::too_steep});
  EXPECT_NEAR(spans[0].to, surfaces::kBowlRadius * std::sin(25 * kDegree),
              settings.edge_tolerance + 2e-6);
  EXPECT_NEAR(spans[1].worst, 0.17, 1e-12);
  EXPECT_NEAR(spans[1].slope, std::asin(0.17 / surfaces::kBowlRadius), 1e-9);
}

TEST(SurfaceWalk, SaysSoWhereAllIsOff) {
  const auto spans = walk_surface(surfaces::line({{0.85, 0}, {0.9, 0}}), surfaces::bowl, {});
  ASSERT_EQ(spans.size(), 1u);
  EXPECT_EQ(spans[0].problem, Problem::off_canvas);
  EXPECT_NEAR(spans[0].worst, 0.05, 1e-12);
  EXPECT_NEAR(std::atof(spans[0].text.c_str()), 120, 0.5)
      << spans[0].text;  // the bowl ends at 0.78
}

TEST(SurfaceWalk, ADotIsOnePlace) {
  const auto on = walk_surface(surfaces::line({{0.6, 0.05}}), holed(0.03), {});
  const auto off = walk_surface(surfaces::line({{0.6, 0}}), holed(0.03), {});
  ASSERT_EQ(on.size(), 1u);
  ASSERT_EQ(off.size(), 1u);
  EXPECT_FALSE(on[0].problem);
  EXPECT_EQ(off[0].problem, Problem::off_canvas);
  EXPECT_EQ(off[0].to, 0);
}

TEST(SurfaceWalk, ProfileIsTheSurface) {
  const PlacedStroke stroke = surfaces::line({{0.5, -0.05}, {0.7, 0.08}});
  const auto spans = walk_surface(stroke, surfaces::waves, {});
  ASSERT_EQ(spans.size(), 1u);
  const SurfaceProfile exact(spans[0], 0), smooth(spans[0], 5e-3);
  for (double s = 0; s <= plane_length(stroke); s += 0.7e-3) {
    const Vector2d at = place_on(stroke, s).p_P;
    const SurfaceSample truth = *surfaces::waves(at.x(), at.y());
    EXPECT_LT((exact.at(s).p_P - truth.p_P).norm(),
              5e-6);  // curvature 32/m over a millimetre: 4 µm
    EXPECT_LT((exact.at(s).n_P - truth.n_P).norm(), 2e-4);
    EXPECT_LT((smooth.at(s).n_P - truth.n_P).norm(), 5e-3);  // n'' w²/24 with n'' about 32 × 40 /m²
  }
}

TEST(SurfaceWalk, ProfileAveragesNormals) {
  // A crease: normals change at once, the average over 5 mm of stroke does so over 5 mm, evenly.
  const auto crease = [](double x, double y) -> std::optional<SurfaceSample> {
    if (x < 0.6) return level(x, y, 0.1);
    return SurfaceSample{{x, y, 0.1 + 0.2 * (x - 0.6)}, Vector3d(-0.2, 0, 1).normalized()};
  };
  const auto spans = walk_surface(surfaces::line({{0.55, 0}, {0.65, 0}}), crease, {});
  ASSERT_EQ(spans.size(), 1u);
  const SurfaceProfile smooth(spans[0], 5e-3);
  const Vector3d after = Vector3d(-0.2, 0, 1).normalized();
  EXPECT_LT((smooth.at(0.0474).n_P - Vector3d::UnitZ()).norm(), 0.02);
  EXPECT_LT((smooth.at(0.0526).n_P - after).norm(), 0.02);
  EXPECT_LT((smooth.at(0.05).n_P - (Vector3d::UnitZ() + after).normalized()).norm(), 0.02);
}

// Half a circle and a corner, of points every 0.02 mm, over a surface that ends at x = 0.59.
TEST(SurfaceWalk, ManyPointsAreNotAskedForOneByOne) {
  const double radius = 0.02, turn = 1e-3;  // [rad]
  std::vector<Vector2d> points;
  for (double a = 0; a < std::numbers::pi; a += turn)
    points.emplace_back(0.6 + radius * std::cos(a), radius * std::sin(a));
  std::vector<Vector2d> corner = points;
  std::reverse(corner.begin(), corner.end());
  for (double y = 0; y < 0.01; y += radius * turn) corner.emplace_back(0.6 + radius, -y);
  int asked = 0;
  double end = -1;
  const SurfaceHeight surface = [&](double x, double y) -> std::optional<SurfaceSample> {
    ++asked;
    if (x < end) return std::nullopt;
    return level(x, y, 0.1);
  };
  const PreflightSettings settings;
  walk_surface(surfaces::line(points), surface, settings);
  EXPECT_LT(asked, 70) << "3142 points on 63 mm";
  end = 0.59;
  const auto spans = walk_surface(surfaces::line(points), surface, settings);
  ASSERT_EQ(spans.size(), 2u);
  EXPECT_NEAR(spans[0].to, radius * 2 * std::numbers::pi / 3 - settings.edge_margin,
              settings.edge_tolerance + 2e-5);
  const auto round_corner = walk_surface(surfaces::line(corner), surface, settings);
  for (const SurfaceSpan& span : {spans[0], round_corner.back()})
    for (const SurfaceSample& at : span.samples) {
      const Vector2d p = at.p_P.head<2>() - Vector2d(0.6, 0);
      EXPECT_NEAR(p.y() < 0 ? p.x() : p.norm(), radius, 2e-5);
    }
}

TEST(SurfaceWalk, SpansCoverTheStrokeFromEndToEnd) {
  const unsigned seed = 20261121;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 300; ++i) {
    const double hole = 0.04 * std::abs(unit(rng)), step = 0.01 * unit(rng), a = 3 * unit(rng),
                 edge = 0.05 * unit(rng);
    const SurfaceHeight surface = [&](double x, double y) -> std::optional<SurfaceSample> {
      if (std::hypot(x - 0.6, y) < hole || y > 0.08) return std::nullopt;
      const double ramp = x > 0.6 + edge ? a * (x - 0.6 - edge) : 0;
      return SurfaceSample{{x, y, 0.1 + ramp + (y > edge ? step : 0)},
                           Vector3d(x > 0.6 + edge ? -a : 0, 0, 1).normalized()};
    };
    PlacedStroke stroke;
    stroke.start = i % 3 * 0.01;
    for (int k = 0; k < 2 + i % 5; ++k) {
      stroke.p_P.push_back({0.6 + 0.1 * unit(rng), 0.1 * unit(rng)});
      stroke.page.push_back(stroke.p_P.back());
    }
    PreflightSettings settings;
    settings.max_slope_deg = 60;
    const auto spans = walk_surface(stroke, surface, settings);
    ASSERT_FALSE(spans.empty());
    EXPECT_NEAR(spans.back().to, stroke.start + plane_length(stroke), 1e-12);
    for (std::size_t k = 0; k < spans.size(); ++k) {
      EXPECT_LE(spans[k].from, spans[k].to);
      EXPECT_EQ(spans[k].from, k > 0 ? spans[k - 1].to : stroke.start);
      EXPECT_EQ(spans[k].problem.has_value(), !spans[k].text.empty());
      if (spans[k].problem) continue;
      EXPECT_EQ(spans[k].along.front(), spans[k].from);
      EXPECT_EQ(spans[k].along.back(), spans[k].to);
      // Asked anew, every place of it can be drawn on.
      for (double s = spans[k].from; s <= spans[k].to; s += 0.37e-3) {
        const Vector2d at = place_on(stroke, s).p_P;
        const auto sample = surface(at.x(), at.y());
        ASSERT_TRUE(sample) << i;
        EXPECT_LT(std::acos(sample->n_P.z()), 60.001 * kDegree);
      }
    }
  }
}

}  // namespace
}  // namespace impedraw
