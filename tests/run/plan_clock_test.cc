#include "impedraw/run/plan_clock.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "impedraw/run/monitors/rattle_monitor.h"
#include "impedraw/run/monitors/speed_monitor.h"

namespace impedraw {
namespace {

constexpr double kDt = 1e-3;

TEST(PlanClock, RunsAsPlannedWhileThePenFollows) {
  PlanClock clock({}, kDt);
  for (int i = 0; i < 5000; ++i) clock.advance({3e-3, 0.05, 0.3, 0.0, 1.0, false});
  EXPECT_EQ(clock.lag(), 0.0);
  EXPECT_EQ(clock.rate(), 1.0);
}

TEST(PlanClock, StopsWhereThePenIsHeldAndGoesOnAfterwards) {
  PlanClock clock({}, kDt);
  for (int i = 0; i < 500; ++i) clock.advance({0.02, 0.0, 0.0, 0.0, 1.0, false});
  EXPECT_EQ(clock.rate(), 0.0);
  const double lag = clock.lag();
  for (int i = 0; i < 2000; ++i) clock.advance({});
  EXPECT_EQ(clock.rate(), 1.0);
  EXPECT_LT(clock.lag() - lag, 0.5) << "it takes up speed within a second";
}

// A rough surface lifts and drops the tip in proportion to the speed along it. The clock settles
// where both agree: r = (stop − r v)/(stop − slow).
TEST(PlanClock, SlowsDownWhereTheTipIsShaken) {
  const ClockSettings settings;
  PlanClock clock(settings, kDt);
  const double rms = 9e-3;  // at full speed [m/s]
  double sum = 0.0;
  for (int i = 0; i < 4000; ++i) {
    PenDeviation pen;
    pen.normal_speed = clock.rate() * rms * std::sqrt(2.0) * std::sin(0.2 * i);
    clock.advance(pen);
    if (i >= 2000) sum += clock.rate() / 2000.0;
  }
  const YieldBounds& bounds = settings.normal_speed;
  EXPECT_NEAR(sum, bounds.stop / (bounds.stop - bounds.slow + rms), 0.02);
}

// Where the pen waits, the plan goes on by way() and no further.
TEST(PlanClock, KnowsHowFarThePlanGoesOnWhileItStops) {
  PlanClock clock({}, kDt);
  for (const int before : {0, 1500, 120, 60}) {  // cycles in which it runs, from a stop on
    for (int i = 0; i < before; ++i) clock.advance({});
    const double way = clock.way(), lag = clock.lag();
    for (int i = 0; i < 300; ++i) clock.advance({0.0, 0.0, 0.0, 0.0, 1.0, true});
    EXPECT_EQ(clock.rate(), 0.0);
    EXPECT_NEAR(300 * kDt - (clock.lag() - lag), way, 1.1 * kDt);
  }
}

// A canvas that is not there must not hold up the drawing.
TEST(PlanClock, LosesPatience) {
  const ClockSettings settings;
  PlanClock clock(settings, kDt);
  for (int i = 0; i < 5000; ++i) clock.advance({0.0, 0.0, 0.0, 0.0, 1.0, true});
  EXPECT_DOUBLE_EQ(clock.rate(), settings.least);
}

// A user's pause lasts as long as it lasts, and the pen's patience is what it was.
TEST(PlanClock, StandsWhileItIsPaused) {
  PlanClock clock({}, kDt);
  PenDeviation paused;
  paused.paused = true;
  for (int i = 0; i < 60000; ++i) clock.advance(paused);
  EXPECT_EQ(clock.rate(), 0.0);
  EXPECT_NEAR(clock.lag(), 60.0, 0.1);
  for (int i = 0; i < 500; ++i) clock.advance({});
  EXPECT_EQ(clock.rate(), 1.0);
}

TEST(PlanClock, TakesUnknownDeviationsForNone) {
  PlanClock clock({}, kDt);
  const double unknown = std::nan("");
  for (int i = 0; i < 100; ++i)
    clock.advance({unknown, unknown, unknown, 0.0, 1.0, false, unknown});
  EXPECT_EQ(clock.rate(), 1.0);
}

// Whatever the pen does: the plan's time never falls, never runs faster than time, and its rate
// changes within its bounds.
TEST(PlanClock, NeverRunsBackwardsNorJumps) {
  const unsigned seed = 20261122;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const ClockSettings settings;
  PlanClock clock(settings, kDt);
  double before = 0.0, rate = 1.0;
  PenDeviation pen;
  for (int i = 1; i <= 200000; ++i) {
    if (uniform(random) < 0.01)
      pen = {0.02 * uniform(random), 0.4 * uniform(random), 4.0 * uniform(random) - 2.0,
             1.3 * uniform(random),  0.2 + uniform(random), uniform(random) < 0.1};
    clock.advance(pen);
    const double planned = i * kDt - clock.lag();
    ASSERT_GE(planned, before - 1e-9);
    ASSERT_LE(planned - before, kDt + 1e-9);
    ASSERT_GE(clock.rate(), 0.0);
    ASSERT_LE(clock.rate(), 1.0);
    ASSERT_LE(std::abs(clock.rate() - rate),
              std::max(settings.slow_down, settings.speed_up) * kDt + 1e-12);
    before = planned;
    rate = clock.rate();
  }
}

// The scaled reference is the derivative of the plan at the clock's time, by finite differences.
TEST(PlanClock, ScalesVelocityAndAcceleration) {
  PlanClock clock({}, kDt);
  const auto plan = [](double s) {  // p = s²
    TipReference reference;
    reference.p_WD.x() = s * s;
    reference.v_WD.x() = 2.0 * s;
    reference.a_WD.x() = 2.0;
    reference.w_WD.x() = reference.yaw_rate = 2.0 * s;  // and angles alike
    reference.alpha_WD.x() = reference.yaw_acceleration = 2.0;
    return reference;
  };
  double p[3] = {}, t = 0.0;
  for (int i = 0; i < 60; ++i) {  // while the rate falls
    const TipReference now = clock.scaled(plan(t - clock.lag()));
    p[0] = p[1], p[1] = p[2], p[2] = now.p_WD.x();
    EXPECT_EQ(now.w_WD.x(), now.v_WD.x());
    EXPECT_EQ(now.yaw_rate, now.v_WD.x());
    EXPECT_EQ(now.alpha_WD.x(), now.a_WD.x());
    EXPECT_EQ(now.yaw_acceleration, now.a_WD.x());
    if (i >= 3 && clock.rate() > 0.0) {
      EXPECT_NEAR(now.v_WD.x(), (p[2] - p[1]) / kDt, 2e-3);
    }
    if (i >= 5) {
      EXPECT_NEAR(now.a_WD.x(), (p[2] - 2.0 * p[1] + p[0]) / (kDt * kDt), 0.1);
    }
    clock.advance({0.02, 0.0, 0.0, 0.0, 1.0, false});
    t += kDt;
  }
}

TEST(PlanClock, SlowsDownForTheSpeedThatAJointWillSoonHave) {
  const ClockSettings s;
  for (const double rise : {0.5, -0.5}) {  // [1/s]
    PlanClock clock(s, kDt);
    PenDeviation pen;
    pen.joint = rise > 0.0 ? 0.3 : 0.84;
    for (int i = 0; i < 2000; ++i) clock.advance(pen);
    for (; rise > 0.0 ? pen.joint < 0.84 : pen.joint > 0.5; pen.joint += rise * kDt)
      clock.advance(pen);
    const double soon = 0.84 + rise * s.foresight;
    EXPECT_NEAR(clock.rate(),
                rise > 0.0 ? (s.joint.stop - soon) / (s.joint.stop - s.joint.slow) : 1.0, 5e-3);
  }
}

TEST(SpeedMonitor, NoticesAJointFarAboveItsLimit) {
  SpeedMonitor monitor(Eigen::Vector2d(1.0, 2.0));
  JointVector v(2);
  v << 0.5, 1.9;
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(monitor.update(v, false, kDt));
  v[1] = 5.5;
  EXPECT_FALSE(monitor.update(v, false, kDt)) << "one outlier of a noisy velocity";
  v[1] = 1.0;
  EXPECT_FALSE(monitor.update(v, false, kDt));
  v[1] = -5.5;
  int steps = 0;
  while (!monitor.update(v, false, kDt)) ASSERT_LT(++steps, 10);
  EXPECT_EQ(monitor.joint(), 1);
}

// A law whose torques are at their limits cannot hold a joint that is too fast.
TEST(SpeedMonitor, TripsEarlierWhereTorquesAreLimited) {
  const JointVector v = JointVector::Constant(1, 1.3);
  SpeedMonitor free(Eigen::VectorXd::Ones(1)), limited(Eigen::VectorXd::Ones(1));
  bool tripped = false;
  for (int i = 0; i < 10; ++i) {
    EXPECT_FALSE(free.update(v, false, kDt));
    tripped |= limited.update(v, true, kDt);
  }
  EXPECT_TRUE(tripped);
}

TEST(SpeedMonitor, TripsAtAJointThatStaysAboveItsLimit) {
  SpeedMonitor stays(Eigen::VectorXd::Ones(1)), comes_back(Eigen::VectorXd::Ones(1));
  bool tripped = false;
  for (int i = 0; i < 1000 && !tripped; ++i) {
    EXPECT_FALSE(
        comes_back.update(JointVector::Constant(1, i % 200 < 150 ? 1.5 : 0.5), false, kDt));
    tripped = stays.update(JointVector::Constant(1, 1.5), false, kDt);
  }
  EXPECT_TRUE(tripped);
}

TEST(SpeedMonitor, TripsAtASwingThatGoesOnAboveALimit) {
  SpeedMonitor swing(Eigen::VectorXd::Ones(1)), stops(Eigen::VectorXd::Ones(1));
  bool tripped = false;
  for (int i = 0; i < 1000 && !tripped; ++i) {
    const double phase = std::sin(0.05 * i);  // 8 Hz
    EXPECT_FALSE(stops.update(JointVector::Constant(1, 1.5 * std::max(0.0, phase)), false, kDt));
    tripped = swing.update(JointVector::Constant(1, 1.5 * phase), false, kDt);
  }
  EXPECT_TRUE(tripped);
  EXPECT_FALSE(swing.swings());
}

// A swing within the speed limits that a limited torque rate feeds. Torques at their limits
// while the arm holds still, or for an instant, are none.
TEST(SpeedMonitor, TripsWhereTorquesStayAtTheirLimitsWhileTheArmSwings) {
  SpeedMonitor swing(Eigen::VectorXd::Ones(1)), holds(Eigen::VectorXd::Ones(1)),
      now_and_then(Eigen::VectorXd::Ones(1));
  bool tripped = false;
  for (int i = 0; i < 400 && !tripped; ++i) {
    const JointVector v = JointVector::Constant(1, 0.6 * std::sin(0.02 * i));
    EXPECT_FALSE(holds.update(0.1 * v, true, kDt));
    EXPECT_FALSE(now_and_then.update(v, i % 50 < 20, kDt));
    tripped = swing.update(v, true, kDt);
  }
  EXPECT_TRUE(tripped);
  EXPECT_TRUE(swing.swings());
}

TEST(RattleMonitor, TripsAtBlowsOfSeveralTimesThePush) {
  RattleMonitor gentle, hammer, air, heavy;
  bool tripped = false;
  for (int i = 0; i < 3000; ++i) {
    const double phase = std::sin(0.5 * i);  // 80 Hz
    EXPECT_FALSE(gentle.update(5.0 + 5.0 * phase, ContactMode::contact, 5.0, 0.0, kDt));
    EXPECT_FALSE(heavy.update(20.0 + 5.0 * phase, ContactMode::contact, 5.0, 0.0, kDt));
    EXPECT_FALSE(air.update(30.0 * phase, ContactMode::free, 5.0, 0.0, kDt));
    tripped |= hammer.update(5.0 + 20.0 * phase, ContactMode::contact, 5.0, 0.0, kDt);
  }
  EXPECT_TRUE(tripped);
  RattleMonitor once;  // a blow of ten times the push, 10 ms long
  for (int i = 0; i < 1000; ++i)
    EXPECT_FALSE(once.update(i < 10 ? 50.0 : 5.0, ContactMode::contact, 5.0, 0.0, kDt)) << i;
}

// The tip leaps by 1.5 mm between touches in both cases. What it is touched by tells them apart.
TEST(RattleMonitor, TellsAStiffCanvasFromOneThatCamerasDoNotResolve) {
  for (const double height : {0.0, 1.1e-3}) {
    RattleMonitor monitor;
    bool tripped = false;
    for (int i = 0; i < 1000; ++i) {
      const bool touches = i % 40 < 4;
      const double ground = (i / 40) % 2 == 0 ? 2e-3 : 2e-3 + height;
      tripped |= monitor.update(touches ? 40.0 : 0.0, ContactMode::contact, 5.0,
                                touches ? ground - 5e-5 : ground + 1.5e-3, kDt);
    }
    EXPECT_TRUE(tripped);
    EXPECT_NEAR(monitor.unevenness(), height, 0.2e-3);
    EXPECT_EQ(monitor.unevenness() > RattleMonitor::kUnseen, height > 0.0);
  }
}

}  // namespace
}  // namespace impedraw
