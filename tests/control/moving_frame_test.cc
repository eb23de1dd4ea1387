// The feed-forward of a moving canvas against finite differences, and against motions whose result
// is known.
#include "impedraw/control/moving_frame.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

namespace impedraw {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

// Smooth functions of time with known derivatives.
struct Wave {
  Vector3d amplitude, rate, phase;
  Vector3d at(double t, int derivative) const {
    const Eigen::Array3d x = rate.array() * t + phase.array();
    const Eigen::Array3d scale = amplitude.array() * rate.array().pow(derivative);
    return derivative == 0   ? Vector3d(scale * x.sin())
           : derivative == 1 ? Vector3d(scale * x.cos())
                             : Vector3d(-scale * x.sin());
  }
};

Vector3d random_vector(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> u(-size, size);
  return {u(random), u(random), u(random)};
}

Wave random_wave(std::mt19937& random, double amplitude) {
  return {random_vector(random, amplitude), random_vector(random, 3.0), random_vector(random, 3.0)};
}

// K turns by θ(t) about a fixed axis and moves as a wave; the tip moves as a wave in K, and its
// normal leans by another.
struct Motion {
  Wave origin, tip, lean, turn;
  Vector3d axis;

  FrameMotion frame(double t) const {
    FrameMotion m;
    m.X_WK = {origin.at(t, 0), AngleAxisd(turn.at(t, 0).x(), axis).toRotationMatrix()};
    m.v = origin.at(t, 1);
    m.a = origin.at(t, 2);
    m.w = turn.at(t, 1).x() * axis;
    m.alpha = turn.at(t, 2).x() * axis;
    return m;
  }
  Vector3d normal(double t) const { return (Vector3d::UnitZ() + lean.at(t, 0)).normalized(); }
  TipReference reference(double t) const {
    TipReference r;
    r.p_WD = tip.at(t, 0);
    r.v_WD = tip.at(t, 1);
    r.a_WD = tip.at(t, 2);
    r.n_WD = normal(t);
    const auto turning = [&](double at) {
      constexpr double h = 1e-4;
      return Vector3d(normal(at).cross((normal(at + h) - normal(at - h)) / (2 * h)));
    };
    constexpr double h = 1e-4;
    r.w_WD = turning(t);
    r.alpha_WD = (turning(t + h) - turning(t - h)) / (2 * h);
    return r;
  }
};

TEST(MovingFrame, CarriedMotionMatchesFiniteDifferences) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Motion motion{random_wave(random, 0.1), random_wave(random, 0.2),
                        random_wave(random, 0.4), random_wave(random, 1.0),
                        random_vector(random, 1.0).normalized()};
    const auto at = [&](double t) { return carried(motion.reference(t), motion.frame(t)); };
    constexpr double h = 1e-4;
    const double t = 0.37;
    const TipReference before = at(t - h), now = at(t), after = at(t + h);
    EXPECT_LT(((after.p_WD - before.p_WD) / (2 * h) - now.v_WD).norm(), 1e-6);
    EXPECT_LT(((after.v_WD - before.v_WD) / (2 * h) - now.a_WD).norm(), 1e-5);
    EXPECT_NEAR(now.n_WD.norm(), 1.0, 1e-12);
    EXPECT_NEAR(now.w_WD.dot(now.n_WD), 0.0, 1e-9);
    EXPECT_LT((now.n_WD.cross((after.n_WD - before.n_WD) / (2 * h)) - now.w_WD).norm(), 1e-5);
    EXPECT_LT(((after.w_WD - before.w_WD) / (2 * h) - now.alpha_WD).norm(), 1e-3);
    const Vector3d point_W = now.p_WD;
    const Vector3d p_K = motion.frame(t).X_WK.inverse() * point_W;
    EXPECT_LT(((motion.frame(t + h).X_WK * p_K - motion.frame(t - h).X_WK * p_K) / (2 * h) -
               motion.frame(t).velocity_at(point_W))
                  .norm(),
              1e-6);
  }
}

TEST(MovingFrame, AFrameAtRestChangesNothing) {
  TipReference r;
  r.p_WD = {0.5, 0.1, 0.2};
  r.v_WD = {0.01, 0.02, 0.0};
  r.a_WD = {0.3, 0.0, 0.1};
  r.n_WD = Vector3d(0.1, 0.2, 0.9).normalized();
  r.w_WD = r.n_WD.unitOrthogonal() * 0.4;
  r.alpha_WD = r.n_WD.cross(r.w_WD);
  r.pen_down = true;
  const TipReference out = carried(r, {});
  EXPECT_EQ(out.p_WD, r.p_WD);
  EXPECT_EQ(out.v_WD, r.v_WD);
  EXPECT_EQ(out.a_WD, r.a_WD);
  EXPECT_EQ(out.n_WD, r.n_WD);
  EXPECT_LT((out.w_WD - r.w_WD).norm(), 1e-12);
  EXPECT_TRUE(out.pen_down);
}

// A pen that stands on a turntable is drawn towards the axis by ω² r.
TEST(MovingFrame, ATurntablePullsTowardsItsAxis) {
  FrameMotion table;
  table.w = {0, 0, 2.0};
  TipReference still;
  still.p_WD = {0.3, 0, 0.1};
  const TipReference out = carried(still, table);
  EXPECT_LT((out.v_WD - Vector3d(0, 0.6, 0)).norm(), 1e-12);
  EXPECT_LT((out.a_WD - Vector3d(-1.2, 0, 0)).norm(), 1e-12);
  EXPECT_LT(out.w_WD.norm(), 1e-12) << "a turn about the pen itself is free";
}

TEST(MovingFrame, ALedHeadingTurnsWithItsTurntableToo) {
  FrameMotion table;
  table.w = {0.0, 0.0, 1.5};
  TipReference led;
  led.x_WD = Eigen::Vector3d::UnitX();
  led.yaw_rate = 0.2;
  EXPECT_NEAR(carried(led, table).yaw_rate, 1.7, 1e-12);
}

}  // namespace
}  // namespace impedraw
