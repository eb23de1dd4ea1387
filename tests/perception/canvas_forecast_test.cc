// Forecasts over seconds, from poses as a tracker gives them, against motions known exactly.
#include "impedraw/perception/canvas_forecast.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "impedraw/common/rotations.h"
#include "impedraw/simulation/canvas_motion.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

const Vector3d kCentre(0.6, 0.0, 0.1);

// As estimated up to `now`: 0.15 mm and 1 mrad off on each axis.
CanvasForecast seen_until(double now, const CanvasMotion& motion, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  CanvasHistory history(kCentre);
  const auto noise = [&](double sigma) {
    return Vector3d(sigma * normal(random), sigma * normal(random), sigma * normal(random));
  };
  for (int i = 0; i <= std::lround(1e3 * now); ++i) {
    Pose X = motion.at(1e-3 * i).X_WK;
    const Vector3d centre = X * kCentre + noise(1.5e-4);
    X.R = rotation(noise(1e-3)) * X.R;
    X.p = centre - X.R * kCentre;
    history.add(1e-3 * i, X);
  }
  return history.forecast();
}

// The largest error of a point 0.1 m beside the centre, from `now` to `ahead` later [m].
double error(const CanvasForecast& forecast, const CanvasMotion& motion, double now, double ahead) {
  const Vector3d p_K = kCentre + Vector3d(0.1, 0.0, 0.0);
  double largest = 0.0;
  for (double t = now; t <= now + ahead; t += 0.05)
    largest = std::max(largest, (forecast.at(t) * p_K - motion.at(t).X_WK * p_K).norm());
  return largest;
}

using Course = CanvasForecast::Course;

TEST(CanvasForecast, StandingStays) {
  const CanvasForecast f = seen_until(6.0, CanvasMotion());
  EXPECT_LT(error(f, CanvasMotion(), 6.0, 20.0), 2e-3);
  EXPECT_EQ(f.text(), "stands");
}

TEST(CanvasForecast, ConveyorGoesOn) {
  CanvasMotionSettings s;
  s.velocity = {0.02, -0.06, 0.01};
  s.start = -5.0;
  const CanvasMotion motion(s);
  const CanvasForecast f = seen_until(6.0, motion);
  EXPECT_EQ(f.shift(), Course::steady);
  EXPECT_LT(error(f, motion, 6.0, 20.0), 4e-3);
  EXPECT_EQ(f.text(), "moves at 0.064 m/s");
}

// A second after it started nothing but that second counts.
TEST(CanvasForecast, ConveyorThatJustStarted) {
  CanvasMotionSettings s;
  s.velocity = {0.0, -0.06, 0.0};
  s.start = 6.0;
  const CanvasMotion motion(s);
  EXPECT_LT(error(seen_until(7.5, motion), motion, 7.5, 10.0), 10e-3);
}

// Two sinusoids bend round a start well enough, but do not tell how it goes on.
TEST(CanvasForecast, StartIsNoSwing) {
  CanvasMotionSettings s;
  s.velocity = {0.0, -0.06, 0.0};
  s.start = 3.0;
  const CanvasMotion motion(s);
  const CanvasForecast f = seen_until(6.0, motion);
  EXPECT_EQ(f.shift(), Course::steady);
  EXPECT_LT(error(f, motion, 6.0, 20.0), 10e-3);
}

// Beside the turntable's middle the canvas goes round: a straight line would be off by 0.2 m.
TEST(CanvasForecast, TurntableGoesRound) {
  CanvasMotionSettings s;
  s.turn_speed = 0.17;
  s.centre = {0.6, 0.2, 0.1};
  s.start = -5.0;
  const CanvasMotion motion(s);
  const CanvasForecast f = seen_until(8.0, motion);
  EXPECT_EQ(f.turn(), Course::steady);
  EXPECT_EQ(f.shift(), Course::steady);
  EXPECT_LT(error(f, motion, 8.0, 10.0), 5e-3);
}

TEST(CanvasForecast, TurntableOnAConveyorGoesOn) {
  CanvasMotionSettings s;
  s.turn_speed = 0.333;
  s.velocity = Vector3d(0.0, -0.033, 0.0);
  s.centre = Vector3d(0.6, 0.1, 0.1);
  s.start = 0.1;
  const CanvasMotion motion(s);
  const CanvasForecast f = seen_until(8.0, motion);
  EXPECT_EQ(f.shift(), Course::steady);
  EXPECT_LT(error(f, motion, 8.0, 15.0), 0.02);
}

TEST(CanvasForecast, SwingsGoOn) {
  CanvasMotionSettings s;
  s.sway = {0.0, 0.05, 0.02};
  s.sway_frequency = 0.5;
  s.roll = 0.087;
  s.roll_frequency = 0.3;
  s.centre = kCentre;
  s.start = -5.0;
  const CanvasMotion motion(s);
  const CanvasForecast f = seen_until(8.0, motion);
  EXPECT_EQ(f.shift(), Course::swinging);
  EXPECT_EQ(f.turn(), Course::swinging);
  EXPECT_LT(error(f, motion, 8.0, 20.0), 5e-3);
  EXPECT_EQ(f.text(), "swings at 0.50 Hz and rocks at 0.30 Hz");
}

TEST(CanvasForecast, SlowSwingWithinOneAndAHalfTurns) {
  CanvasMotionSettings s;
  s.sway = {0.0, 0.2, 0.0};
  s.sway_frequency = 0.2;
  s.start = -5.0;
  const CanvasMotion motion(s);
  EXPECT_LT(error(seen_until(8.0, motion), motion, 8.0, 20.0), 20e-3);
}

// Nothing is known of the seconds to come, but that they will be as those before.
TEST(CanvasForecast, JoltsAreTheirMean) {
  CanvasMotionSettings s;
  s.jolts = 0.015;
  s.start = -5.0;
  const CanvasMotion motion(s);
  const CanvasForecast f = seen_until(8.0, motion);
  EXPECT_EQ(f.shift(), Course::unsteady);
  EXPECT_NEAR(f.unexplained(), std::sqrt(3.0) * 0.015, 0.008);
  EXPECT_LT(error(f, motion, 8.0, 20.0), 0.08);
}

// A course that jolts only blur counts.
TEST(CanvasForecast, ConveyorOrSwingThatIsJoltedGoesOn) {
  CanvasMotionSettings s;
  s.jolts = 0.007;
  s.velocity = Vector3d(-0.007, -0.039, 0.0);
  s.start = -5.0;
  const CanvasMotion conveyor(s);
  EXPECT_LT(error(seen_until(12.0, conveyor), conveyor, 12.0, 15.0), 0.06);
  s.velocity.setZero();
  s.sway = Vector3d(0.0, 0.1, 0.0);
  s.sway_frequency = 0.25;
  s.jolts = 0.003;
  const CanvasMotion swing(s);
  EXPECT_LT(error(seen_until(12.0, swing), swing, 12.0, 6.0), 0.05);
}

// A long time without estimates: what was before does not tell.
TEST(CanvasForecast, StartsAnewAfterALongGap) {
  CanvasHistory history(kCentre);
  for (int i = 0; i < 100; ++i) history.add(0.04 * i, {Vector3d(0.01 * i, 0.0, 0.0)});
  Pose there;
  there.p = {0.0, 0.3, 0.0};
  for (int i = 0; i < 100; ++i) history.add(20.0 + 0.04 * i, there);
  EXPECT_LT((history.forecast().at(40.0).p - there.p).norm(), 1e-6);
}

}  // namespace
}  // namespace impedraw
