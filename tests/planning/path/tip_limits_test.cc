// p, v, a and n, w, alpha are each other's derivatives, and no limit is passed, on drawings of
// every kind.
#include <random>

#include <gtest/gtest.h>

#include "impedraw/planning/path/tip_planner.h"
#include "planning/surfaces.h"
#include "seeds.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

void check(const TipPath& path, const PathSettings& s) {
  const double h = 2e-6, step = std::max(1e-3, path.duration() / 15000);
  const double most = std::max({s.draw_acceleration, s.travel_acceleration}),
               jerk = 40 * most / s.smoothing_time;
  for (double t = 0.77e-3; t < path.duration(); t += step) {
    SCOPED_TRACE(t);
    const PathSample now = path.at(t);
    const TipReference &g = now.reference, a = path.at(t - h).reference,
                       b = path.at(t + h).reference;
    ASSERT_LT(((b.p_WD - a.p_WD) / (2 * h) - g.v_WD).norm(), 1e-6);
    ASSERT_LT(((b.v_WD - a.v_WD) / (2 * h) - g.a_WD).norm(), jerk * h + 1e-6);  // a is continuous
    ASSERT_NEAR(g.n_WD.norm(), 1, 1e-12);
    ASSERT_LT(((b.n_WD - a.n_WD) / (2 * h) - g.w_WD.cross(g.n_WD)).norm(), 1e-5);
    ASSERT_LT(std::abs(g.w_WD.dot(g.n_WD)), 1e-12 + 1e-9 * g.w_WD.norm());
    ASSERT_LT(((b.w_WD - a.w_WD) / (2 * h) - g.alpha_WD).norm(), 1e-2 + 1e-2 * g.alpha_WD.norm());
    const bool seen = now.phase == Phase::draw && !s.vertical_pen;  // along the drawing axis
    const double speed = g.v_WD.norm(),
                 acceleration = seen ? g.a_WD.head<2>().norm() : g.a_WD.norm();
    const bool drawing = now.phase == Phase::draw, approaching = now.phase == Phase::approach;
    ASSERT_LE(speed, (drawing       ? s.draw_speed
                      : approaching ? s.approach_speed
                                    : s.travel_speed) *
                         (1 + 1e-9));
    ASSERT_LE(acceleration, (drawing || approaching ? s.draw_acceleration : s.travel_acceleration) *
                                (seen ? 1.01 : 1 + 1e-9));
    ASSERT_TRUE(drawing || g.w_WD.norm() <= s.turn_speed * (1 + 1e-9));
    ASSERT_TRUE(!drawing || g.w_WD.norm() <= s.tilt_speed * 1.02);
    ASSERT_TRUE(!drawing || g.alpha_WD.norm() <= s.tilt_acceleration * 1.05);
  }
}

TEST(TipLimits, BuiltInShapesOnTheBowl) {
  for (const std::string& name : shape_names()) {
    SCOPED_TRACE(name);
    const PathSettings settings;
    check(plan_tip_path(surfaces::shape(name), surfaces::bowl, settings), settings);
  }
}

// A surface with waves of 8 mm and slopes of 20°: standing on its normal at 50 mm/s the pen would
// turn at 14 rad/s. It leaves the normal by no more than the allowance, and does not crawl.
TEST(TipLimits, ARoughSurfaceDoesNotShakeThePen) {
  constexpr double kWave = 2 * 3.14159265358979 / 8e-3, kHeight = 0.36 / kWave;
  const SurfaceHeight rough = [](double x, double y) -> std::optional<SurfaceSample> {
    const Vector3d n(-kHeight * kWave * std::cos(kWave * x), 0, 1);
    return SurfaceSample{{x, y, 0.1 + kHeight * std::sin(kWave * x)}, n.normalized()};
  };
  PathSettings settings;
  const TipPath path =
      plan_tip_path({surfaces::line({{0.55, 0.0}, {0.65, 0.01}})}, rough, settings);
  check(path, settings);
  for (double t = 0; t < path.duration(); t += 1e-3) {
    const PathSample now = path.at(t);
    if (now.phase != Phase::draw) continue;
    const Vector3d n = rough(now.reference.p_WD.x(), now.reference.p_WD.y())->n_P;
    // the smoothed normals, which the allowance counts from, are within 20° of the true ones
    ASSERT_GT(now.reference.n_WD.dot(n), std::cos(0.35 + 0.18));
  }
  const StrokeTimes stroke = path.strokes().front();
  EXPECT_GT(stroke.length / (stroke.end - stroke.start), 0.015);
}

TEST(TipLimits, FastAndBlind) {
  PathSettings settings;
  settings.draw_speed = 0.2;
  settings.draw_acceleration = 5;
  check(plan_tip_path(surfaces::shape("sine"), surfaces::bowl, settings), settings);
  settings.vertical_pen = true;
  settings.sink = 0.02;
  check(plan_tip_path(surfaces::shape("sine"), surfaces::bowl, settings), settings);
}

// Wandering lines, polygons, spirals, dots, on a wavy surface.
std::vector<PlacedStroke> random_strokes(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-1, 1);
  std::vector<PlacedStroke> strokes;
  for (int k = 0; k < 4; ++k) {
    std::vector<Vector2d> points{{0.6 + 0.1 * any(random), 0.1 * any(random)}};
    double direction = 3 * any(random), bend = 0;
    const double side = std::pow(10.0, -4.2 + 1.2 * any(random)),
                 wildness = 0.1 * (1 + any(random));
    const int count = k == 3 ? 0 : 60;
    for (int i = 0; i < count; ++i) {
      bend = 0.9 * bend + wildness * any(random);
      direction += bend;
      if (i % 17 == 5) direction += 2 * any(random);
      points.push_back(points.back() + side * Vector2d(std::cos(direction), std::sin(direction)));
    }
    strokes.push_back(surfaces::line(points));
  }
  return strokes;
}

TEST(TipLimits, RandomStrokesOnWaves) {
  for (unsigned seed = 0; seed < seeds(25, 150); ++seed) {
    SCOPED_TRACE(seed);
    PathSettings settings;
    settings.smoothing_time = seed % 3 == 0 ? 0.02 : 0.04;
    settings.draw_speed = seed % 2 ? 0.05 : 0.12;
    const std::vector<PlacedStroke> strokes = random_strokes(seed);
    const TipPath path = plan_tip_path(strokes, surfaces::waves, settings);
    check(path, settings);
    // The desired point stays within the tolerance of the artwork, and on the surface.
    for (std::size_t k = 0; k < strokes.size(); ++k) {
      const StrokeTimes& s = path.strokes()[k];
      for (double t = s.start; t < s.end; t += std::max(1e-3, (s.end - s.start) / 500)) {
        const Vector3d p = path.at(t).reference.p_WD;
        double nearest = (p.head<2>() - strokes[k].p_P[0]).norm();
        for (std::size_t i = 1; i < strokes[k].p_P.size(); ++i) {
          const Vector2d a = strokes[k].p_P[i - 1], side = strokes[k].p_P[i] - a;
          const double f = std::clamp((p.head<2>() - a).dot(side) / side.squaredNorm(), 0.0, 1.0);
          nearest = std::min(nearest, (p.head<2>() - a - f * side).norm());
        }
        ASSERT_LE(nearest, std::max(settings.tolerance, settings.rounding)) << k;
        ASSERT_NEAR(p.z(), surfaces::waves(p.x(), p.y())->p_P.z(), 3e-6) << k;
      }
    }
  }
}

}  // namespace
}  // namespace impedraw
