// Planned paths on canvases that move: where and when the arm does not follow, against brute force.
#include "impedraw/planning/preflight/carried_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "arm_on_surface.h"
#include "impedraw/arm/inverse_kinematics.h"
#include "impedraw/planning/path/tip_planner.h"
#include "impedraw/planning/preflight/reach_map.h"
#include "planning/surfaces.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

TipPath path_of(const std::vector<PlacedStroke>& strokes) {
  PathSettings path;
  path.start_p_WE = {0.5, 0, 0.3};
  return plan_tip_path(strokes, surfaces::flat(0.1), path);
}

CanvasCourse conveyor(double speed, double from = 0.0) {
  return [=](double t) { return Pose{Vector3d(0.0, -speed * std::max(0.0, t - from), 0.0)}; };
}

// Whether any of many postures has the pen there.
bool reaches(ArmModel& arm, const Vector3d& p, const PreflightSettings& settings) {
  std::mt19937 random(1);
  const ArmLimits& limits = arm.limits();
  for (int i = 0; i < 12; ++i) {
    JointVector seed = surfaces::start_posture(arm);
    if (i > 0)
      for (Eigen::Index j = 0; j < seed.size(); ++j)
        seed[j] = limits.lower[j] + (limits.upper[j] - limits.lower[j]) * random() / 4294967295.0;
    const IkResult found = find_posture(arm, {p, -Vector3d::UnitZ()}, seed);
    const double room =
        std::min((found.q - limits.lower).minCoeff(), (limits.upper - found.q).minCoeff());
    if (found.reached && room > settings.joint_margin) return true;
  }
  return false;
}

TEST(CarriedPath, OnACanvasThatStandsIsAsThePreflightSays) {
  ArmModel arm(surfaces::kArm);
  const TipPath path = path_of(surfaces::shape("M"));
  const CarriedPath carried{&path, 3.0, [](double) { return Pose(); }, {}};
  const auto fault = check_carried(carried, arm, nullptr, surfaces::start_posture(arm), {});
  EXPECT_FALSE(fault) << fault->what << ": " << fault->how;
}

// The pen is still taken along while it leaves the canvas.
TEST(CarriedPath, LooksBeyondTheLastLift) {
  ArmModel arm(surfaces::kArm);
  const TipPath path = path_of({surfaces::line({{0.6, 0.1}, {0.6, -0.1}}, 0)});
  CarriedPath carried{&path, 0.0, conveyor(0.25, path.strokes().back().end), {}};
  EXPECT_FALSE(check_carried(carried, arm, nullptr, surfaces::start_posture(arm), {}));
  carried.along = 3.0;
  const auto fault = check_carried(carried, arm, nullptr, surfaces::start_posture(arm), {});
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->stroke, 0u);
  EXPECT_GT(fault->time, path.strokes().back().end + 0.5);
}

TEST(CarriedPath, TellsWhenAConveyorLeavesTheReachAndHowFar) {
  ArmModel arm(surfaces::kArm);
  PreflightSettings settings;
  settings.space.max_effective_mass = 1e4;
  const TipPath path = path_of({surfaces::line({{0.6, 0.1}, {0.6, -0.1}}, 0),
                                surfaces::line({{0.62, -0.1}, {0.62, 0.1}}, 1)});
  const double speed = 0.08, begin = 20.0;
  const CanvasCourse canvas = conveyor(speed, begin);
  const CarriedPath carried{&path, begin, canvas, {}};
  const auto fault = check_carried(carried, arm, nullptr, surfaces::start_posture(arm), settings);
  ASSERT_TRUE(fault);
  // By brute force: the first place of the carried path that no posture reaches, and the last.
  double first = 0.0;
  for (double t = 0.0; t < path.duration() && first == 0.0; t += 0.1)
    if (!reaches(arm, canvas(begin + t) * path.at(t).reference.p_WD, settings)) first = begin + t;
  EXPECT_NEAR(fault->time, first, 0.4);
  EXPECT_EQ(fault->stroke, first < begin + path.strokes()[0].end ? 0u : 1u);
  EXPECT_EQ(fault->what.find("brings a joint") != std::string::npos ||
                fault->what.find("arm's reach") != std::string::npos,
            true)
      << fault->what;
  // How far: never more than the canvas went since.
  EXPECT_GT(fault->short_by, 0.01);
  EXPECT_LT(fault->short_by, speed * path.duration());
}

TEST(CarriedPath, StartsLaterWithoutFaultWhereTheCanvasStops) {
  ArmModel arm(surfaces::kArm);
  const TipPath path = path_of({surfaces::line({{0.6, 0.1}, {0.6, -0.1}}, 0)});
  const CarriedPath carried{
      &path, 0.0, [](double t) { return Pose{Vector3d(0.0, -0.1 * std::min(t, 2.0), 0.0)}; }, {}};
  const auto fault = check_carried(carried, arm, nullptr, surfaces::start_posture(arm), {});
  EXPECT_FALSE(fault) << fault->what << ": " << fault->how;
}

// In reach all the time, but a joint would have to be faster than it can.
TEST(CarriedPath, JointSpeedsCount) {
  ArmModel arm(surfaces::kArm);
  const TipPath path = path_of({surfaces::line({{0.55, 0.05}, {0.55, -0.05}}, 0)});
  const auto swing = [&](double amplitude) {
    const CarriedPath carried{
        &path,
        0.0,
        [=](double t) {
          return Pose{Vector3d(0.0, amplitude * std::sin(2.0 * std::numbers::pi * 1.5 * t), 0.0)};
        },
        {}};
    return check_carried(carried, arm, nullptr, surfaces::start_posture(arm), {});
  };
  EXPECT_FALSE(swing(0.02));
  const auto fault = swing(0.2);
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->what, "needs too fast a joint");
}

// A table that rises under the arm: the arm touches it where it is, not where it was.
TEST(CarriedPath, ObstaclesMoveWithTheCanvas) {
  ArmModel arm(surfaces::kArm);
  const TriangleMesh mesh{{{0.3, -0.6, 0.0}, {0.9, -0.6, 0.0}, {0.9, 0.6, 0.0}, {0.3, 0.6, 0.0}},
                          {{0, 1, 2}, {0, 2, 3}}};
  const Canvas beside(mesh);
  const TipPath path = path_of({surfaces::line({{0.6, 0.05}, {0.6, -0.05}}, 0)});
  const auto at = [&](double height) {
    // The path stays in W, as it is given in K: lowered by what K rises.
    const CarriedPath carried{&path, 0.0, [=](double) { return Pose{Vector3d(0.0, 0.0, height)}; },
                              [](const TipReference& in_K, double) { return in_K; }};
    return check_carried(carried, arm, &beside, surfaces::start_posture(arm), {});
  };
  EXPECT_FALSE(at(0.05));
  const auto fault = at(0.35);
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->what, "makes the arm touch the canvas or the table");
}

CanvasPoses poses_of(const CanvasCourse& canvas, double until) {
  CanvasPoses poses;
  for (double t = 0.0; t <= until; t += poses.step) poses.X_WK.push_back(canvas(t));
  return poses;
}

bool lies_in(double start, double duration, const std::vector<ReachWindow>& windows) {
  return std::ranges::any_of(windows, [&](const ReachWindow& w) {
    return start >= w.from - 1e-9 && start + duration <= w.until + 1e-9;
  });
}

// Begun anywhere within a window, and nowhere else, the stroke is in reach at all times, its way
// down and its lift included.
TEST(CarriedPath, WindowsOfASwingAreThoseOfBruteForce) {
  ArmModel arm(surfaces::kArm);
  PreflightSettings settings;
  settings.space.max_effective_mass = 1e4;
  const TipPath path = path_of({surfaces::line({{0.6, 0.45}, {0.6, 0.40}}, 0)});
  const CanvasCourse canvas = [](double t) {
    return Pose{Vector3d(0.0, 0.3 * std::sin(2.0 * std::numbers::pi * 0.1 * t), 0.0)};
  };
  const double duration = path.strokes()[0].end - path.strokes()[0].approach;
  ReachMap reach(arm, surfaces::start_posture(arm), settings);
  const std::vector<ReachWindow> windows = reach.windows(path, 0, poses_of(canvas, 25.0));
  ASSERT_EQ(windows.size(), 2u) << "in reach in each half turn away from the limit";
  int differ = 0, n = 0;
  for (double t = 1.0; t + duration < 24.0; t += 0.5, ++n) {
    bool all = true;
    const double begin = t - path.strokes()[0].approach;
    for (double s = path.strokes()[0].approach - 0.4; all && s < path.duration(); s += 0.2)
      all = reaches(arm, canvas(begin + s) * path.at(s).reference.p_WD, settings);
    differ += all != lies_in(t, duration, windows);
  }
  EXPECT_LE(differ, 4) << "of " << n << ": at the windows' edges only";
}

// A stroke of two swings, whose ends and middle pass by while they are in reach. The defect: seven
// places along a stroke were looked at, each as the pen came by, and none between.
TEST(CarriedPath, AStrokeLongerThanASwingHasNoWindow) {
  ArmModel arm(surfaces::kArm);
  std::vector<Eigen::Vector2d> there_and_back;
  for (int i = 0; i < 8; ++i) there_and_back.push_back({0.6, i % 2 ? 0.40 : 0.50});
  const TipPath path = path_of({surfaces::line(there_and_back, 0)});
  const double duration = path.strokes()[0].end - path.strokes()[0].approach;
  const CanvasCourse canvas = [&](double t) {
    return Pose{Vector3d(0.0, 0.2 * std::sin(2.0 * std::numbers::pi * 3.0 / duration * t), 0.0)};
  };
  ReachMap reach(arm, surfaces::start_posture(arm), {});
  EXPECT_TRUE(reach.windows(path, 0, poses_of(canvas, 60.0)).empty());
}

// In reach all the time, and yet in no window while a joint would be too fast.
TEST(CarriedPath, WindowsCountJointSpeeds) {
  ArmModel arm(surfaces::kArm);
  const TipPath path = path_of({surfaces::line({{0.55, 0.05}, {0.55, -0.05}}, 0)});
  const auto windows = [&](double amplitude) {
    ReachMap reach(arm, surfaces::start_posture(arm), {});
    const CanvasCourse canvas = [=](double t) {
      const double stops = t < 20.0 ? 1.0 : 0.0;
      return Pose{Vector3d(0.0, stops * amplitude * std::sin(2.0 * std::numbers::pi * t), 0.0)};
    };
    return reach.windows(path, 0, poses_of(canvas, 30.0));
  };
  ASSERT_EQ(windows(0.01).size(), 1u);
  EXPECT_LT(windows(0.01).front().from, 1.0);
  ASSERT_EQ(windows(0.25).size(), 1u);
  EXPECT_GT(windows(0.25).front().from, 20.0);
}

}  // namespace
}  // namespace impedraw
