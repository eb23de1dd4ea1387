// Monitors that judge whole cycles, against the times and distances of their headers.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/run/monitors/block_monitor.h"
#include "impedraw/run/monitors/canvas_monitor.h"
#include "impedraw/run/monitors/dead_wrench_monitor.h"
#include "impedraw/run/monitors/fence_monitor.h"
#include "impedraw/run/monitors/range_monitor.h"
#include "impedraw/run/monitors/rattle_monitor.h"
#include "impedraw/run/monitors/reach_monitor.h"
#include "impedraw/run/monitors/reversal_monitor.h"
#include "impedraw/run/monitors/speed_monitor.h"
#include "impedraw/run/monitors/state_monitor.h"
#include "impedraw/run/monitors/step_time_monitor.h"
#include "impedraw/run/monitors/tare_monitor.h"
#include "impedraw/run/reaction.h"
#include "made_up_cycle.h"
#include "prepared.h"

namespace impedraw {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

// Cycles until judge() says something, and what it says.
template <class Judge>
int cycles_until(Judge&& judge, Verdict* said) {
  for (int n = 1; n <= 100000; ++n) {
    *said = judge();
    if (*said) return n;
  }
  return -1;
}

// A pad that slid off its line was sent back to before the place that held it, time and again.
TEST(BlockMonitor, APlaceBeginsWhereTheTipIs) {
  const Prepared e = prepared("bowl-sine");
  BlockMonitor monitor(e);
  ASSERT_TRUE(monitor.feels());
  MadeUpCycle made;
  made.out.mode = ContactMode::contact;
  made.out.n_WD = Eigen::Vector3d::UnitZ();
  made.out.p_WD = made.arm.X_WE.p + Eigen::Vector3d(0.02, 0.0, 0.005);
  made.desired.stroke = 0;
  made.desired.along = 0.178;
  made.state.shaft_touches = true;
  std::optional<StrokePart> place;
  ASSERT_TRUE(monitor.judge(made.next(), e.plan.path, 0.0, false, &place));
  ASSERT_TRUE(place);
  EXPECT_NEAR(place->from, 0.158, 1e-12);
  EXPECT_NEAR(place->to, 0.178, 1e-12);
}

TEST(StateMonitor, EndsARunWithoutAUsableStateForItsTime) {
  MadeUpCycle made;
  StateMonitor monitor;
  Verdict said;
  made.out.status.stale_state = true;
  const auto judge = [&] { return monitor.judge(made.next(), ""); };
  EXPECT_NEAR(cycles_until(judge, &said), kBadStateTime / MadeUpCycle::kDt, 1.5);
  EXPECT_EQ(said.severity, Severity::lose);
  EXPECT_THAT(said.cause, StartsWith("the controller was given joint states that are stale"));

  StateMonitor other;
  made.out.status = {};
  EXPECT_FALSE(other.judge(made.next(), ""));
  EXPECT_EQ(other.judge(made.next(), "no connection").cause, "no connection");
  made.out.status.bad_input = true;
  made.arm.v[0] = std::nan("");
  EXPECT_GT(cycles_until([&] { return other.judge(made.next(), ""); }, &said), 100);
  EXPECT_THAT(said.cause, HasSubstr("numbers that are not finite, as joint velocities, for 0.2 s"));
}

TEST(TareMonitor, AllowsForTheRestAndForAMotionBefore) {
  for (const double moved : {0.0, 0.5}) {
    MadeUpCycle made;
    made.tared = false;
    TareMonitor monitor(1.0, 0.2);
    if (moved > 0.0) monitor.moves_first(moved);
    Verdict said;
    const int n = cycles_until([&] { return monitor.judge(made.next()); }, &said);
    EXPECT_NEAR(n * MadeUpCycle::kDt, 1.0 + moved, 2.5 * MadeUpCycle::kDt);
    EXPECT_EQ(said.severity, Severity::lose);
    made.tared = true;
    EXPECT_FALSE(monitor.judge(made.next()));
  }
}

TEST(StepTimeMonitor, LiftsThePenAfterAStall) {
  MadeUpCycle made;
  StepTimeMonitor monitor;
  EXPECT_FALSE(monitor.judge(made.next()));
  made.step_time = 0.05;
  const Verdict said = monitor.judge(made.next());
  EXPECT_EQ(said.severity, Severity::lift);
  EXPECT_EQ(said.end, RunEnd::stopped);
  EXPECT_EQ(said.cause, "a control step took too long at t = 0.001 s; the pen was lifted");
  Cycle of_pad = made.next();
  of_pad.tool = "pad";
  EXPECT_THAT(monitor.judge(of_pad).cause, EndsWith("; the pad was lifted"));
}

TEST(SpeedMonitor, NamesTheJointAndLetsTheDrawingGoOn) {
  MadeUpCycle made;
  SpeedMonitor monitor(Eigen::VectorXd::Constant(1, 2.0), {"joint_4"});
  made.arm.v[0] = 2.6;  // 1.3 of the limit
  made.out.status.torque_limited = true;
  Verdict said;
  EXPECT_NEAR(cycles_until([&] { return monitor.judge(made.next()); }, &said), 3, 1);
  EXPECT_EQ(said.severity, Severity::brake);
  EXPECT_EQ(said.end, RunEnd::finished);
  EXPECT_EQ(said.calm, JointSpeedShares::kCalm);
  EXPECT_THAT(said.cause,
              StartsWith("joint_4 was above its speed limit of 2.00 rad/s at t = 0.00"));
  EXPECT_THAT(said.cause, HasSubstr(", with torques at their limits"));
}

// Cycles from the turn of a force, in the pen's axes, until it is named; −1: within 20 it is not.
int cycles_until_reversal(const Eigen::Vector3d& before, const Eigen::Vector3d& after,
                          const Eigen::Vector3d& weight = Eigen::Vector3d::Zero()) {
  MadeUpCycle made;
  ReversalMonitor monitor;
  for (int n = -20; n < 20; ++n) {
    // The reading is the next cycle's; its last digit is noise.
    made.F_ext.head<3>() = made.state.wrench.head<3>() - weight;
    made.state.wrench.head<3>() = (n < 0 ? before : after) + weight;
    made.state.wrench[0] += 1e-3 * (n % 3);
    if (monitor.judge(made.next())) return n;
  }
  return -1;
}
TEST(ReversalMonitor, NamesAWrenchThatTurnsOverAndNoFrictionThatDoes) {
  EXPECT_EQ(cycles_until_reversal({1.5, 0.0, -5.0}, {-1.5, 0.0, 5.0}), 2);
  EXPECT_EQ(cycles_until_reversal({1.5, 0.0, -5.0}, {-1.5, 0.0, -5.0}), -1);  // friction
  EXPECT_EQ(cycles_until_reversal({4.0, 0.0, -5.0}, {-4.0, 0.0, -5.0}, {0.0, 0.0, 5.0}), -1);
  EXPECT_EQ(cycles_until_reversal({0.0, 0.0, -5.0}, {0.0, 0.0, 0.0}), -1);   // lifted
  EXPECT_EQ(cycles_until_reversal({0.0, 0.0, -5.0}, {0.0, 0.0, 12.0}), -1);  // a hand
  EXPECT_EQ(cycles_until_reversal({0.0, 0.0, -1.0}, {0.0, 0.0, 1.0}), -1);   // noise
}

// Wires, at heights that differ, are left if walls are felt; a canvas that is too stiff is not.
TEST(RattleMonitor, LeavesAPlaceThatCamerasDoNotResolveAndEndsAtAStiffCanvas) {
  const auto verdict = [](double height, bool feels) {
    MadeUpCycle made;
    made.out.mode = ContactMode::contact;
    made.out.push = 5.0;
    RattleMonitor monitor(4e4, feels);
    Verdict said;
    int i = 0;
    cycles_until(
        [&] {
          const bool touches = ++i % 20 == 0;
          made.F_ext.head<3>() = (touches ? 60.0 : 0.0) * made.out.n_WD;
          made.surface.distance = touches && i % 40 == 0 ? -height : 0.0;
          return monitor.judge(made.next());
        },
        &said);
    return said;
  };
  EXPECT_EQ(verdict(0.0, true).severity, Severity::brake);
  EXPECT_EQ(verdict(1e-3, false).severity, Severity::brake);
  EXPECT_THAT(verdict(0.0, true).cause, HasSubstr("contact_stiffness_max, 4e+04 N/m"));
  const Verdict wires = verdict(1e-3, true);
  EXPECT_EQ(wires.severity, Severity::lift);
  EXPECT_EQ(wires.end, RunEnd::finished);
}

// A cutter's score is pushed with 0.3 N; what comes down meets the canvas no softer for that.
TEST(RattleMonitor, TakesNoTouchdownUnderALightPushForHammering) {
  MadeUpCycle made;
  made.out.mode = ContactMode::contact;
  made.out.push = 0.3;
  RattleMonitor monitor(4e4);
  for (int i = 0; i < 1000; ++i) {
    made.F_ext.head<3>() = (i < 20 ? 4.0 : 0.3) * made.out.n_WD;
    EXPECT_FALSE(monitor.judge(made.next())) << i;
  }
}

// A canvas that all cameras see.
CanvasEstimate seen() {
  CanvasEstimate estimate;
  estimate.status = CanvasStatus::ok;
  return estimate;
}

TEST(ReachMonitor, LetsGoOfACanvasThatRunsAway) {
  for (const bool goes_on : {true, false}) {
    MadeUpCycle made;
    made.canvas = CanvasFollower([](double) { return seen(); });
    ReachMonitor monitor(goes_on, JointVector::Ones(made.arm.v.size()));
    made.out.p_WD = made.arm.X_WE.p + Eigen::Vector3d(1.1 * ReachMonitor::kFar, 0.0, 0.0);
    for (int i = 0; i < 1000; ++i)
      ASSERT_FALSE(monitor.judge(made.next())) << "the pen does not move with the canvas";
    made.canvas.update(0.0);
    made.canvas.join({});
    Verdict said;
    const int n = cycles_until([&] { return monitor.judge(made.next()); }, &said);
    EXPECT_NEAR(n * MadeUpCycle::kDt, ReachMonitor::kConfirm, 1.5 * MadeUpCycle::kDt);
    EXPECT_EQ(said.severity, Severity::lift);
    EXPECT_EQ(said.rise, Verdict::Rise::let_go);
    EXPECT_EQ(said.end, goes_on ? RunEnd::finished : RunEnd::stopped);
  }
}

TEST(ReachMonitor, LetsGoBeforeTheCanvasStretchesTheArm) {
  MadeUpCycle made;
  made.canvas = CanvasFollower([](double) { return seen(); });
  made.canvas.update(0.0);
  made.canvas.join({});
  ReachMonitor monitor(true, JointVector::Ones(made.arm.v.size()));
  made.arm.v[0] = -0.88;
  for (int i = 0; i < 1000; ++i) ASSERT_FALSE(monitor.judge(made.next()));
  made.arm.v[0] = -0.92;
  Verdict said;
  const int n = cycles_until([&] { return monitor.judge(made.next()); }, &said);
  EXPECT_NEAR(n * MadeUpCycle::kDt, ReachMonitor::kRaces, 1.5 * MadeUpCycle::kDt);
  EXPECT_EQ(said.rise, Verdict::Rise::let_go);
  EXPECT_EQ(said.end, RunEnd::finished);
}

TEST(CanvasFollower, LeavesACanvasSoonerAcrossTheWayUpThanAlongIt) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ(), moves(0.0, 0.2, 0.1);
  CanvasFollower follower([&](double time) {
    CanvasEstimate estimate = seen();
    estimate.motion.X_WK.p = time * moves;
    estimate.motion.v = moves;
    return estimate;
  });
  follower.update(0.0);
  follower.join({}, 0.0);
  follower.leave(2.0, up);
  for (double t = 0.0, last = 0.0; t <= 2.0; t += 1e-3) {
    follower.update(t);
    const TipReference at = follower.in_world({});
    EXPECT_LE(at.p_WD.y(), moves.y() * CanvasFollower::kShed);
    EXPECT_LT(std::abs(at.p_WD.y() - last), 1e-3) << "no jump";
    last = at.p_WD.y();
    EXPECT_EQ(follower.leaves(), t < CanvasFollower::kShed);
    if (t >= CanvasFollower::kShed) {
      EXPECT_NEAR(at.v_WD.y(), 0.0, 1e-9);
      EXPECT_NEAR(at.p_WD.y(), 0.0, 1e-9);
    }
    if (t > 0.6 && t < 1.0) {
      EXPECT_GT(at.p_WD.z(), 0.0);
    }
  }
}

TEST(CanvasMonitor, HoldsThePlanWhileTheCanvasIsLostAndLeavesThePathOnceItIsFound) {
  CanvasStatus status = CanvasStatus::ok;
  MadeUpCycle made;
  made.canvas = CanvasFollower([&status](double) {
    CanvasEstimate estimate = seen();
    estimate.status = status;
    return estimate;
  });
  CanvasMonitor monitor(false);
  monitor.begin_path();
  made.canvas.update(0.0);
  made.canvas.join({});
  EXPECT_FALSE(monitor.hold(made.next()));
  EXPECT_FALSE(monitor.judge(made.next(), false));
  status = CanvasStatus::lost;
  made.canvas.update(0.1);
  made.out.mode = ContactMode::lift;
  made.desired.phase = Phase::lift;
  EXPECT_FALSE(monitor.hold(made.next())) << "a lift goes on";
  made.desired.phase = Phase::travel;
  made.out.mode = ContactMode::retreat;
  EXPECT_EQ(monitor.hold(made.next()).severity, Severity::hold);
  EXPECT_FALSE(monitor.judge(made.next(), false));
  EXPECT_TRUE(monitor.let_go());
  status = CanvasStatus::ok;
  made.canvas.update(0.2);
  EXPECT_FALSE(monitor.hold(made.next()));
  EXPECT_EQ(monitor.judge(made.next(), false).severity, Severity::leave);

  status = CanvasStatus::lost;
  made.canvas.update(0.3);
  for (int i = 0; i < 60000; ++i)
    ASSERT_LT(monitor.judge(made.next(), true).severity, Severity::lift) << "paused";
  Verdict said;
  const double before = monitor.waited();
  const int n = cycles_until([&] { return monitor.judge(made.next(), false); }, &said);
  EXPECT_NEAR(before + n * MadeUpCycle::kDt, CanvasMonitor::kMostWait, 0.01);
  EXPECT_THAT(said.cause, StartsWith("no camera has known the canvas for 45 s"));
}

// Where the pen is 1 mm beneath the surface, on it or on its way down, and what the wrench tells.
TEST(DeadWrenchMonitor, NamesAWrenchThatTellsNothingOfWhatHoldsThePen) {
  const auto says = [](ContactMode mode, double held, double told, double distance = -1e-3) {
    MadeUpCycle made;
    made.out.mode = mode;
    made.out.n_WD = Eigen::Vector3d::UnitZ();
    made.out.push = 5.0;
    made.F_ext[2] = told;
    made.surface.status = SurfaceStatus::ok;
    made.surface.distance = distance;
    DeadWrenchMonitor monitor;
    for (int n = 1; n <= 100; ++n) {
      const Verdict said = monitor.judge(made.next(), held);
      if (!said) continue;
      EXPECT_EQ(said.severity, Severity::damp);
      EXPECT_THAT(said.cause, StartsWith("the pen is held as by"));
      return n;
    }
    return -1;
  };
  EXPECT_NEAR(says(ContactMode::contact, 16.0, 0.0), DeadWrenchMonitor::kConfirm / 1e-3, 1.5);
  EXPECT_EQ(says(ContactMode::contact, 14.0, 0.0), -1) << "less than three pushes";
  EXPECT_EQ(says(ContactMode::contact, 16.0, 2.5), -1) << "the wrench tells half of the push";
  EXPECT_EQ(says(ContactMode::contact, 16.0, 0.0, 0.0), -1) << "on the surface, as a hand does it";
  EXPECT_EQ(says(ContactMode::approach, 40.0, 0.0), -1) << "friction holds it, too";
  EXPECT_GT(says(ContactMode::approach, 46.0, 0.0), 0);
  EXPECT_EQ(says(ContactMode::free, 46.0, 0.0), -1);
}

TEST(SecondChance, IsGivenToAnArmThatDrewWellAndAlone) {
  const auto after = [](double drawn, double force, bool possible) {
    MadeUpCycle made;
    made.desired.stroke = 0;
    made.inked = true;
    SecondChance chance(possible);
    for (double t = 0.0; t < drawn; t += MadeUpCycle::kDt) chance.update(made.next());
    made.out.n_WD = Eigen::Vector3d::UnitX();
    made.out.push = 15.0;
    made.F_ext[0] = force;
    made.inked = false;
    for (int i = 0; i < 100; ++i) chance.update(made.next());
    return chance;
  };
  EXPECT_TRUE(after(2.5, 25.0, true).given());
  EXPECT_FALSE(after(1.5, 25.0, true).given()) << "it has hardly drawn";
  EXPECT_FALSE(after(2.5, 45.0, true).given()) << "a hand pushes";
  EXPECT_FALSE(after(2.5, 25.0, false).given());
  SecondChance chance = after(2.5, 25.0, true);
  chance.take();
  EXPECT_FALSE(chance.given()) << "it has to draw again first";
}

// A blow of 15 ms is none; one axis at its end for 20 ms is.
TEST(RangeMonitor, NamesASensorThatStaysAtTheEndOfItsRange) {
  WrenchEstimatorSettings sensor;
  sensor.range_force = 99.98;
  sensor.range_torque = 9.999;
  RangeMonitor monitor(sensor);
  MadeUpCycle c;
  for (int i = 0; i < 15; ++i) {
    c.state.wrench[1] = -100.0;
    EXPECT_FALSE(monitor.judge(c.next()));
  }
  c.state.wrench.setConstant(9.0);
  EXPECT_FALSE(monitor.judge(c.next()));
  c.state.wrench[5] = 10.0;
  c.tared = false;  // why it cannot be tared is said elsewhere
  for (int i = 0; i < 30; ++i) EXPECT_FALSE(monitor.judge(c.next()));
  c.tared = true;
  Verdict said;
  EXPECT_EQ(cycles_until([&] { return monitor.judge(c.next()); }, &said), 20);
  EXPECT_EQ(said.severity, Severity::halt);
  EXPECT_THAT(said.cause, HasSubstr("stays at the end of its range"));
  c.state.wrench.setZero();
  EXPECT_FALSE(monitor.judge(c.next()));
  c.state.wrench[1] = -100.0;
  EXPECT_EQ(cycles_until([&] { return monitor.judge(c.next()); }, &said), 20);
}

TEST(FenceMonitor, NamesTheFenceThatWasCrossed) {
  FenceSettings fence;
  fence.low = {-1.0, -1.0, -1.0};
  fence.high = {1.0, 1.0, 1.0};
  fence.force = 10.0;
  fence.moment = 2.0;
  fence.speed = 0.5;
  const auto crossed = [&](auto&& change) {
    FenceMonitor monitor(fence, true);
    MadeUpCycle c;
    for (int i = 0; i < 10; ++i) EXPECT_FALSE(monitor.judge(c.next()));
    change(c);
    Verdict said;
    const int cycles = cycles_until([&] { return monitor.judge(c.next()); }, &said);
    return fmt::format("{} {}", cycles, said.cause);
  };
  EXPECT_THAT(crossed([](auto& c) { c.arm.X_WE.p.y() = -1.1; }), StartsWith("1 fence.low"));
  EXPECT_THAT(crossed([](auto& c) { c.arm.X_WE.p.y() = 1.1; }), StartsWith("1 fence.high"));
  EXPECT_THAT(crossed([](auto& c) { c.F_ext[1] = -11.0; }), StartsWith("3 fence.force"));
  EXPECT_THAT(crossed([](auto& c) { c.F_ext[4] = -2.1; }), StartsWith("3 fence.moment"));
  EXPECT_THAT(crossed([](auto& c) { c.arm.V_WE[2] = -0.6; }), StartsWith("3 fence.speed"));
  std::swap(fence.low, fence.high);
  EXPECT_THROW(FenceMonitor(fence, true), InputError);
}

}  // namespace
}  // namespace impedraw
