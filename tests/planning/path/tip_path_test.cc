// What the path does when: phases, strokes, corners, dots, blind drawing, errors.
#include <gmock/gmock.h>
#include <numbers>
#include <random>
#include <tuple>

#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "impedraw/drawing/polyline.h"
#include "impedraw/planning/path/tip_planner.h"
#include "planning/surfaces.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using surfaces::line;

std::string message(const std::vector<PlacedStroke>& strokes, const PathSettings& settings = {},
                    const SurfaceHeight& surface = surfaces::bowl) {
  try {
    plan_tip_path(strokes, surface, settings);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::vector<Phase> phases(const TipPath& path) {
  std::vector<Phase> order;
  for (double t = 0; t <= path.duration() + 0.01; t += 1e-3) {
    const Phase phase = path.at(t).phase;
    if (order.empty() || order.back() != phase) order.push_back(phase);
  }
  return order;
}

// A large drawing has a million legs.
TEST(TipPath, LegsAreSmall) { EXPECT_LE(sizeof(PathLeg), 32u); }

TEST(TipPath, PhasesFollowOneAnother) {
  const TipPath path = plan_tip_path(
      {line({{0.55, 0}, {0.6, 0.05}}), line({{0.6, -0.05}, {0.65, -0.05}})}, surfaces::bowl);
  using enum Phase;
  EXPECT_THAT(phases(path), testing::ElementsAre(travel, approach, draw, lift, travel, approach,
                                                 draw, lift, done));
}

TEST(TipPath, StartsAtTheStartAndEndsAboveTheLastPoint) {
  PathSettings settings;
  settings.start_p_WE = {0.4, 0.1, 0.05};  // lower than the safe height
  settings.start_n_W = Vector3d(0.1, 0.2, 1).normalized();
  settings.highest_z = 0.16;
  const TipPath path = plan_tip_path({line({{0.55, 0}, {0.6, 0.05}})}, surfaces::bowl, settings);
  EXPECT_LT((path.at(0).reference.p_WD - settings.start_p_WE).norm(), 1e-12);
  EXPECT_LT((path.at(0).reference.n_WD - settings.start_n_W).norm(), 1e-12);
  EXPECT_LT((path.at(0.2).reference.p_WD.head<2>() - settings.start_p_WE.head<2>()).norm(),
            1e-12);  // straight up first
  const PathSample end = path.at(path.duration() + 5);
  const SurfaceSample last = *surfaces::bowl(0.6, 0.05);
  EXPECT_NEAR(end.reference.p_WD.z(), 0.16 + settings.safe_height, 1e-9);
  EXPECT_LT((end.reference.p_WD - last.p_P).normalized().cross(last.n_P).norm(),
            5e-5);  // along the normal
  EXPECT_EQ(end.phase, Phase::done);
  EXPECT_EQ(end.stroke, -1);
  EXPECT_FALSE(end.reference.pen_down);
  EXPECT_EQ(path.at(-1).reference.p_WD, path.at(0).reference.p_WD);
}

// A lift along the normal would lead out of the arm's reach where the lines that cover an area end.
TEST(TipPath, LiftsGoStraightUpFromAPlaceThatIsSteeperThanAsked) {
  const Vector3d above = surfaces::bowl(0.6, 0.05)->p_P + 0.01 * surfaces::bowl(0.6, 0.05)->n_P;
  PathSettings settings;
  settings.highest_z = 0.16;
  settings.steep = 0.0;
  const TipPath path = plan_tip_path({line({{0.55, 0}, {0.6, 0.05}})}, surfaces::bowl, settings);
  const Vector3d end = path.at(path.duration()).reference.p_WD;
  EXPECT_LT((end - above).head<2>().norm(), 1e-6);
  EXPECT_NEAR(end.z(), 0.16 + settings.safe_height, 1e-9);
}

// An arm cannot hold its pen at 60° wherever it can hold it at 35°.
TEST(TipPath, ThePenRightsItselfBetweenStrokesOnASteepSurface) {
  const double slope = std::tan(60.0 * std::numbers::pi / 180.0);
  const SurfaceHeight steep = [slope](double x, double y) -> std::optional<SurfaceSample> {
    return SurfaceSample{{x, y, 0.1 + slope * (x - 0.6)}, Vector3d(-slope, 0, 1).normalized()};
  };
  PathSettings settings;
  const TipPath path = plan_tip_path(
      {line({{0.6, -0.05}, {0.6, -0.03}}), line({{0.6, 0.03}, {0.6, 0.05}}, 1)}, steep, settings);
  double drawn = 0.0, least = 1e9;
  for (double t = 0.0; t < path.duration(); t += 1e-3) {
    const PathSample s = path.at(t);
    const double leaning = std::acos(s.reference.n_WD.z());
    if (s.phase == Phase::draw) drawn = std::max(drawn, leaning);
    // Between the strokes, at the safe height.
    if (s.phase == Phase::travel && s.reference.p_WD.z() > 0.1 + settings.safe_height - 1e-6)
      least = std::min(least, leaning);
    ASSERT_LT(s.reference.w_WD.norm(), settings.turn_speed + 1e-9);
  }
  EXPECT_NEAR(drawn, 60.0 * std::numbers::pi / 180.0, 1e-6);
  EXPECT_LT(least, 35.0 * std::numbers::pi / 180.0 + 1e-9);
}

// Each stroke's own lean holds on its two ways.
TEST(TipPath, EachWayHasItsOwnLean) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  const SurfaceHeight steep = [](double x, double) -> std::optional<SurfaceSample> {
    const double slope = std::tan(60.0 * kDegree);
    return SurfaceSample{{x, 0.0, 0.1 + slope * (x - 0.6)}, Vector3d(-slope, 0, 1).normalized()};
  };
  std::vector<PlacedStroke> strokes{line({{0.6, -0.05}, {0.6, -0.03}}),
                                    line({{0.6, 0.03}, {0.6, 0.05}}, 1)};
  strokes[0].lean_off = 20.0 * kDegree;
  strokes[1].lean_there = 50.0 * kDegree;
  strokes[1].lean_off = 5.0 * kDegree;
  const TipPath path = plan_tip_path(strokes, steep, {});
  std::vector<double> at_rest;  // where the pen stands at the safe height: leans [rad]
  for (const double t : {path.strokes()[0].end, path.strokes()[1].end}) {
    double later = t;
    while (path.at(later).phase != Phase::travel && path.at(later).phase != Phase::done)
      later += 1e-3;
    at_rest.push_back(std::acos(path.at(later).reference.n_WD.z()));
  }
  EXPECT_NEAR(at_rest[0], 20.0 * kDegree, 0.02);
  EXPECT_NEAR(at_rest[1], 5.0 * kDegree, 0.02);
  // The way to the second stroke ends above it, where it has turned to that stroke's lean.
  double beside = 1e9, leans = 0.0;
  for (double t = path.strokes()[0].end; t < path.strokes()[1].approach; t += 1e-3) {
    const TipReference now = path.at(t).reference;
    const double off =
        (now.p_WD - Vector3d(now.p_WD.x(), 0.03, 0.1 + PathSettings().safe_height)).norm();
    if (off < beside) beside = off, leans = std::acos(now.n_WD.z());
  }
  EXPECT_NEAR(leans, 50.0 * kDegree, 0.02);
}

// Held at 60° on the surface, a wrist may not hold it at 60° a centimetre above. The rim of a pad
// of 30 mm stays clear meanwhile.
TEST(TipPath, ThePenRightsItselfWithinTheFirstCentimetreOffASteepSurface) {
  constexpr double kRadius = 0.015, kLean = 35.0 * std::numbers::pi / 180.0;
  const double slope = std::tan(60.0 * std::numbers::pi / 180.0);
  const Vector3d n = Vector3d(-slope, 0, 1).normalized();
  const SurfaceHeight steep = [&](double x, double y) -> std::optional<SurfaceSample> {
    return SurfaceSample{{x, y, 0.1 + slope * (x - 0.6)}, n};
  };
  const TipPath path = plan_tip_path({line({{0.6, -0.05}, {0.6, -0.03}})}, steep);
  int near = 0, lifted = 0;
  double turned_before = 0.0;
  for (double t = 0.0; t < path.duration(); t += 1e-3) {
    const PathSample s = path.at(t);
    const double height = n.dot(s.reference.p_WD - Vector3d(0.6, 0.0, 0.1)),
                 turned = std::acos(std::min(1.0, n.dot(s.reference.n_WD)));
    if (s.phase == Phase::draw || height > 0.0135) continue;
    ++near;
    EXPECT_LE(kRadius * std::sin(turned), height + 1e-9) << t;
    if (t > 0.0 && s.phase == Phase::lift && height < 0.0099) {
      ++lifted;
      EXPECT_NEAR(s.reference.w_WD.norm(), (turned - turned_before) / 1e-3, 5e-3) << t;
    }
    if (s.phase == Phase::lift && height > 0.01 + 1e-6)
      EXPECT_NEAR(std::acos(s.reference.n_WD.z()), kLean, 1e-6) << t;
    turned_before = turned;
  }
  EXPECT_GT(near, 200);
  EXPECT_GT(lifted, 100);
}

TEST(TipPath, StrokeAndPenDownAreTimedAsMeasured) {
  const std::vector<PlacedStroke> strokes{line({{0.55, 0}, {0.6, 0.05}}),
                                          line({{0.6, -0.05}, {0.65, -0.05}, {0.65, 0}}, 1)};
  const PathSettings settings;
  const TipPath path = plan_tip_path(strokes, surfaces::bowl, settings);
  ASSERT_EQ(path.strokes().size(), 2u);
  for (int k = 0; k < 2; ++k) {
    const StrokeTimes& s = path.strokes()[k];
    const Vector3d first =
        surfaces::bowl(strokes[k].p_P.front().x(), strokes[k].p_P.front().y())->p_P;
    const Vector3d last = surfaces::bowl(strokes[k].p_P.back().x(), strokes[k].p_P.back().y())->p_P;
    EXPECT_EQ(path.at(s.start - 1e-6).stroke, -1);
    EXPECT_EQ(path.at(s.start + 1e-6).stroke, k);
    EXPECT_EQ(path.at(s.end - 1e-6).stroke, k);
    EXPECT_EQ(path.at(s.end + 1e-6).stroke, -1);
    EXPECT_LT((path.at(s.start).reference.p_WD - first).norm(), 1e-9);
    EXPECT_LT((path.at(s.end).reference.p_WD - last).norm(), 1e-9);
    EXPECT_GT((path.at(s.start + 0.03).reference.p_WD - first).norm(),
              1e-6);  // it does leave at that instant
    EXPECT_GT((path.at(s.end - 0.03).reference.p_WD - last).norm(), 1e-6);
    // Down from the approach's start to the lift's, settled before drawing.
    EXPECT_FALSE(path.at(s.approach - 1e-6).reference.pen_down);
    EXPECT_TRUE(path.at(s.approach + 1e-6).reference.pen_down);
    EXPECT_NEAR((path.at(s.approach).reference.p_WD - first).norm(), settings.hover_height, 1e-9);
    EXPECT_LT((path.at(s.start - settings.settle_time + 1e-6).reference.p_WD - first).norm(), 1e-9);
    EXPECT_TRUE(path.at(s.end + settings.end_hold - 1e-6).reference.pen_down);
    EXPECT_FALSE(path.at(s.end + settings.end_hold + 1e-6).reference.pen_down);
    EXPECT_EQ(path.at(s.end + settings.end_hold + 1e-6).phase, Phase::lift);
  }
}

TEST(TipPath, SineKeepsToItsFormulaAndItsSpeed) {
  const TipPath path = plan_tip_path(surfaces::shape("sine"), surfaces::bowl, surfaces::brisk());
  const StrokeTimes& s = path.strokes().at(0);
  EXPECT_GE(1e3 * s.length / (s.end - s.start), 49.0);  // mm/s
  double arc = 0;
  Vector3d last = path.at(s.start).reference.p_WD;
  for (double t = s.start; t <= s.end; t += 1e-3) {
    const TipReference reference = path.at(t).reference;
    const Vector3d& p = reference.p_WD;
    ASSERT_NEAR(p.x(), 0.60 + 0.05 * std::sin(2 * std::numbers::pi * (p.y() + 0.15) / 0.15),
                2.4e-5);  // 0.01 mm across, slope up to 2.1
    ASSERT_NEAR((p - surfaces::kBowlCentre).norm(), surfaces::kBowlRadius, 1e-7);
    ASSERT_LT(reference.n_WD.cross((surfaces::kBowlCentre - p).normalized()).norm(),
              5e-4);  // smoothing takes up to 0.03° off, at the ends
    arc += (p - last).norm();
    last = p;
  }
  EXPECT_NEAR(arc, s.length, 1e-5);
  EXPECT_NEAR(path.pen_down_length(), s.length, 1e-15);
}

// A cloud's normals are noisy, and two derivatives of noise were 40 Nm a step at 0.3 m/s.
TEST(TipPath, NoiseOfTheNormalsIsNotFedForward) {
  const unsigned seed = 5;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  constexpr double kNoise = 1e-3;  // [rad] on each axis
  const auto most_alpha = [&](double smoothing, double* error) {
    std::mt19937 bits(seed);
    std::uniform_real_distribution<double> noise(-kNoise, kNoise);
    const auto noisy = [&](double x, double y) {
      std::optional<SurfaceSample> sample = surfaces::bowl(x, y);
      if (sample)
        sample->n_P = (sample->n_P + Vector3d(noise(bits), noise(bits), noise(bits))).normalized();
      return sample;
    };
    PathSettings settings;
    settings.draw_speed = 0.3;
    settings.draw_acceleration = 5.0;
    settings.tilt_speed = 20.0;  // no limit
    settings.tilt_acceleration = 1000.0;
    settings.normal_smoothing = smoothing;
    const TipPath path = plan_tip_path(surfaces::shape("sine"), noisy, settings);
    double most = 0.0;
    *error = 0.0;
    for (double t = path.strokes()[0].start; t <= path.strokes()[0].end; t += 1e-3) {
      const TipReference reference = path.at(t).reference;
      most = std::max(most, reference.alpha_WD.norm());
      *error += reference.n_WD.cross((surfaces::kBowlCentre - reference.p_WD).normalized()).norm();
    }
    return most;
  };
  double raw_error, error;
  const double raw = most_alpha(0.0, &raw_error), smoothed = most_alpha(5e-3, &error);
  EXPECT_LT(smoothed, 0.1 * raw);
  EXPECT_LT(error, 0.7 * raw_error) << "in the mean";
}

// Towards z, by half of the slope, but at most by what is asked for.
TEST(TipPath, ThePenLeansTowardsTheDrawingsAxis) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  for (const auto& [slope, lean, axis] :
       {std::tuple(50.0, 20.0, 30.0), {30.0, 20.0, 15.0}, {60.0, 0.0, 60.0}, {0.0, 20.0, 0.0}}) {
    const double rise = std::tan(slope * kDegree);
    const auto hill = [rise](double x, double) {
      return SurfaceSample{{x, 0.0, 0.1 + rise * (x - 0.6)}, Vector3d(-rise, 0, 1).normalized()};
    };
    PathSettings settings;
    settings.lean_deg = lean;
    for (const auto& stroke : {line({{0.6, 0.0}, {0.62, 0.0}}), line({{0.6, 0.0}})}) {
      const TipPath path = plan_tip_path({stroke}, hill, settings);
      const StrokeTimes& s = path.strokes().at(0);
      const Vector3d n = path.at((s.start + s.end) / 2).reference.n_WD;
      const Vector3d expected(-std::sin(axis * kDegree), 0.0, std::cos(axis * kDegree));
      EXPECT_LT((n - expected).norm(), 1e-6) << slope << "°, " << stroke.p_P.size() << " points";
    }
  }
}

TEST(TipPath, MStopsAtItsCorners) {
  const TipPath path = plan_tip_path(surfaces::shape("M"), surfaces::bowl, surfaces::brisk());
  const StrokeTimes& s = path.strokes().at(0);
  EXPECT_GE(1e3 * s.length / (s.end - s.start), 48.0);
  for (const Vector2d& corner : {Vector2d(0.68, 0.08), Vector2d(0.60, 0), Vector2d(0.68, -0.08)}) {
    double nearest = 1, speed = 1;
    for (double t = s.start; t < s.end; t += 1e-4) {
      const TipReference reference = path.at(t).reference;
      const double d = (reference.p_WD.head<2>() - corner).norm();
      if (d < nearest) nearest = d, speed = reference.v_WD.norm();
    }
    EXPECT_LT(nearest, 1e-8);
    EXPECT_LT(speed, 1e-3);
  }
}

TEST(TipPath, DotsAreHeld) {
  const PathSettings settings;
  const TipPath path = plan_tip_path({line({{0.6, 0.02}}), line({{0.6, 0.05}, {0.6, 0.05}})},
                                     surfaces::bowl, settings);
  for (const StrokeTimes& s : path.strokes()) {
    EXPECT_NEAR(s.end - s.start, settings.dot_time, 1e-12);
    EXPECT_EQ(s.length, 0);
    EXPECT_EQ(path.at(s.start + 0.01).reference.v_WD.norm(), 0);
  }
}

TEST(TipPath, BlindDrawsSunkWithAnUprightPen) {
  PathSettings settings = surfaces::brisk();
  settings.vertical_pen = true;
  settings.sink = 0.01;
  const TipPath path = plan_tip_path(surfaces::shape("M"), surfaces::bowl, settings);
  const StrokeTimes& s = path.strokes().at(0);
  for (double t = 0; t < path.duration(); t += 1e-3) {
    const PathSample sample = path.at(t);
    ASSERT_EQ(sample.reference.n_WD, Vector3d(Vector3d::UnitZ()));
    ASSERT_EQ(sample.reference.w_WD.norm(), 0);
    if (sample.stroke < 0) continue;
    const Vector3d& p = sample.reference.p_WD;
    ASSERT_NEAR(p.z(), surfaces::bowl(p.x(), p.y())->p_P.z() - 0.01, 1e-6);
  }
  // Sunk gradually: straight down through the surface at the approach's speed.
  const double down = (settings.hover_height + settings.sink) / settings.approach_speed;
  EXPECT_NEAR(s.start - s.approach, down + settings.settle_time, 0.06);
  for (double t = s.approach; t < s.start; t += 1e-3)
    ASSERT_LE(path.at(t).reference.v_WD.norm(), settings.approach_speed + 1e-9);
}

TEST(TipPath, PolygonsSmallTurnsAreRoundedWithinTheTolerance) {
  // Ten turns of 20° with sides of 10 mm: no stop, never further off than allowed, seen from above.
  // Sides of 1 mm: a fortieth of them.
  const struct {
    double side, rounding, allowed;
  } cases[] = {{0.01, 0.0, 1e-5}, {0.01, 5e-5, 5e-5}, {1e-3, 5e-5, 2.5e-5}};
  std::vector<double> slowest;
  for (const auto& c : cases) {
    std::vector<Vector2d> polygon{{0.58, -0.03}};
    for (int i = 0; i < 10; ++i)
      polygon.push_back(polygon.back() + c.side * Vector2d(std::cos(i * std::numbers::pi / 9),
                                                           std::sin(i * std::numbers::pi / 9)));
    PathSettings settings = surfaces::brisk();
    settings.rounding = c.rounding;
    const TipPath path = plan_tip_path({line(polygon)}, surfaces::bowl, settings);
    const StrokeTimes& s = path.strokes().at(0);
    double v = 1, worst = 0;
    for (double t = s.start; t <= s.end; t += 5e-4) {
      const TipReference reference = path.at(t).reference;
      worst = std::max(worst, distance(reference.p_WD.head<2>(), polygon, 0, polygon.size() - 1));
      if (t > s.start + 0.2 && t < s.end - 0.2) v = std::min(v, reference.v_WD.norm());
    }
    EXPECT_LE(worst, c.allowed);
    slowest.push_back(v);
  }
  EXPECT_GT(slowest[0], 0.01);
  EXPECT_GT(slowest[1], 1.8 * slowest[0]);
}

TEST(TipPath, JitterOfFinePointsIsNotDrawn) {
  // Rounded to 0.001 mm and 0.02 mm apart, as programs export: still drawn at full speed.
  std::vector<Vector2d> points;
  for (int i = 0; i <= 5000; ++i) {
    const double a = i * 2e-4;
    points.push_back({std::round(1e6 * (0.6 + 0.1 * std::cos(a))) / 1e6,
                      std::round(1e6 * 0.1 * std::sin(a)) / 1e6});
  }
  const TipPath path = plan_tip_path({line(points)}, surfaces::bowl, surfaces::brisk());
  const StrokeTimes& s = path.strokes().at(0);
  EXPECT_GE(1e3 * s.length / (s.end - s.start), 47.0);
  for (double t = s.start; t <= s.end; t += 1e-3)
    ASSERT_NEAR((path.at(t).reference.p_WD.head<2>() - Vector2d(0.6, 0)).norm(), 0.1, 1.1e-5);
}

TEST(TipPath, LeavingTheCanvasSaysWhereAndByHowMuch) {
  PlacedStroke out = line({{0.6, 0.1}, {0.6, 0.2}});
  out.page = {{-100, 0}, {-200, 0}};
  out.number = 1;
  EXPECT_EQ(message({line({{0.6, 0}, {0.6, 0.1}}), out}),
            "stroke 1 leaves the canvas at page (-200.00, 0.00) mm, world (0.6000, 0.2000) m, 20.0 "
            "mm off it");
  EXPECT_NE(message({line({{5, 5}})}).find("more than 500 mm off it"), std::string::npos);
  // Also where only the way between two of its points does.
  EXPECT_NE(message({line({{0.6, -0.05}, {0.6, 0.05}})}, {},
                    [](double x, double y) {
                      return std::abs(y) < 0.004 ? std::nullopt : surfaces::table(x, y);
                    })
                .find("stroke 0 leaves the canvas at"),
            std::string::npos);
}

TEST(TipPath, BadSettingsAreNamed) {
  const std::vector<PlacedStroke> strokes{line({{0.6, 0}, {0.6, 0.1}})};
  PathSettings settings;
  settings.draw_speed = 0;
  EXPECT_EQ(message(strokes, settings), "path.draw_speed is 0 m/s, allowed is 1e-04 to 1 m/s");
  settings = {};
  settings.sink = std::nan("");
  EXPECT_EQ(message(strokes, settings), "path.sink is nan m, allowed is at least 0 m");
  settings = {};
  settings.corner_angle_deg = 120;
  EXPECT_EQ(message(strokes, settings),
            "path.corner_angle is 120 deg, allowed is at least 1 and less than 90 deg");
  EXPECT_EQ(message({}), "path: there are no strokes to plan");
  EXPECT_EQ(message({line({{0.6, 0}, {std::nan(""), 0}})}),
            "stroke 0: point 1 is not a finite number");
}

}  // namespace
}  // namespace impedraw
