// A lifted pen against a body that comes nearer, by integration of the law's closed loop.
#include "impedraw/control/hit_retreat.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

using Eigen::Vector3d;

struct Course {
  double most = 0.0, gap = 0.0, left = 0.0;  // force [N]; at the body's stop, and at the end [m]
};

// M ẍ = B (v_D − ẋ) + K (x_D − x) + f of mode free; a wall rises at `speed` by `way`, then stands.
Course hit(double speed, double way, bool yields) {
  constexpr double M = 1.5, B = 76.0, K = 1500.0, k = 20e3, b = 60.0, h = 1e-3;
  HitRetreat retreat;
  Course course;
  double x = 0.0, v = 0.0, f = 0.0;
  for (int i = 0; i < 6000; ++i) {
    const double t = i * h, wall = std::min(way, speed * t) - 0.01,
                 wall_v = wall < way - 0.01 ? speed : 0.0;
    retreat.update(f * Vector3d::UnitZ(), true, h);
    TipReference reference;
    reference.p_WD.setZero();
    reference.v_WD.setZero();
    if (yields) reference = retreat.of(reference);
    f = wall > x ? std::max(0.0, k * (wall - x) + b * (wall_v - v)) : 0.0;
    course.most = std::max(course.most, f);
    v += h / M * (B * (reference.v_WD.z() - v) + K * (reference.p_WD.z() - x) + f);
    x += h * v;
    if (std::abs(t - way / speed) < h) course.gap = x - wall;
  }
  course.left = x - (way - 0.01);
  return course;
}

TEST(HitRetreat, ForceStaysThatOfTheImpact) {
  for (const double speed : {0.02, 0.05}) {
    SCOPED_TRACE(speed);
    const Course yields = hit(speed, 0.04, true), stays = hit(speed, 0.04, false);
    EXPECT_LT(yields.most, 12.0);
    EXPECT_GT(stays.most, 40.0) << "the law's spring alone presses against it";
    EXPECT_GT(yields.left, -3e-3) << "the pen comes back no further than to its touch";
  }
}

TEST(HitRetreat, ReturnsWhenNothingIsThere) {
  HitRetreat retreat;
  for (int i = 0; i < 50; ++i) retreat.update({0.0, 0.0, 8.0}, true, 1e-3);
  for (int i = 0; i < 300; ++i) retreat.update(Vector3d::Zero(), true, 1e-3);
  const double far = retreat.shift().z();
  EXPECT_GT(far, HitRetreat::kClear);
  for (int i = 0; i < 8000; ++i) retreat.update(Vector3d::Zero(), true, 1e-3);
  EXPECT_NEAR(retreat.shift().norm(), 0.0, 1e-9);
}

// The defect: the reference of a pen that was hit jumped back by 25 mm as its plan went on to the
// approach, and the tip met the canvas with 45 N.
TEST(HitRetreat, APenThatComesDownReturnsSlowly) {
  HitRetreat retreat;
  for (int i = 0; i < 50; ++i) retreat.update({0.0, 0.0, 8.0}, true, 1e-3);
  double last = retreat.shift().norm();
  EXPECT_GT(last, 5e-3);
  for (int i = 0; i < 3000; ++i) {
    retreat.update({0.0, 0.0, 5.0}, false, 1e-3);
    const double now = retreat.shift().norm();
    EXPECT_GT(now - last, -1.01e-3 * HitRetreat::kReturn) << i;
    EXPECT_LE(now, last);
    last = now;
  }
  EXPECT_EQ(last, 0.0);
}

TEST(HitRetreat, SmallForcesAndAPenOnTheCanvasMoveNothing) {
  HitRetreat retreat;
  for (int i = 0; i < 500; ++i) retreat.update({0.0, 0.0, 1.9}, true, 1e-3);
  EXPECT_EQ(retreat.shift().norm(), 0.0);
  for (int i = 0; i < 500; ++i) retreat.update({0.0, 0.0, 20.0}, false, 1e-3);
  EXPECT_EQ(retreat.shift().norm(), 0.0);
}

TEST(HitRetreat, GoesAsFastAsItsDamperLetsTheForceBeyondWhatIsFelt) {
  HitRetreat retreat;
  for (int i = 0; i < 300; ++i) retreat.update({0.0, 8.0, 0.0}, true, 1e-3);
  EXPECT_NEAR(retreat.of({}).v_WD.y(), (8.0 - HitRetreat::kFelt) / HitRetreat::kDamping, 1e-6);
}

TEST(HitRetreat, GoesClearOfWhatTouchedItBrieflyAndNoFurther) {
  HitRetreat retreat;
  retreat.update({0.0, 0.0, 2.0001}, true, 1e-3);
  for (int i = 0; i < 500; ++i) retreat.update(Vector3d::Zero(), true, 1e-3);
  EXPECT_NEAR(retreat.shift().z(), HitRetreat::kClear, 1e-6);
}

}  // namespace
}  // namespace impedraw
