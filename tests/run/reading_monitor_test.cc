// Readings of an arm that cannot be true together: each rule with the smallest lie that trips it,
// and with one that does not.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/run/monitors/reading_monitor.h"
#include "made_up_cycle.h"

namespace impedraw {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

// What 1000 readings of two joints contradict; empty: nothing. Position [rad] and speed [rad/s] of
// the second are functions of the time [s]. Rated: 1 rad/s, 10 Nm.
std::string cause_of(const auto& position, const auto& speed, double torque = 0.0,
                     double external = 0.0) {
  MotionCheck check(JointVector::Ones(2), JointVector::Constant(2, 10.0));
  JointVector q = JointVector::Zero(2), v = q, tau = q, known = q;
  tau[1] = torque;
  known[1] = external;
  for (int i = 0; i < 1000 && check.cause().empty(); ++i) {
    q[1] = position(1e-3 * i);
    v[1] = speed(1e-3 * i);
    check.update(q, &v, tau, known, 1e-3);
  }
  return check.cause();
}

TEST(MotionCheck, NamesAPositionThatJumpsFurtherThanAnyMotion) {
  const auto jump = [](double by) {
    return cause_of([by](double t) { return t < 0.5 ? 0.0 : by; }, [](double) { return 0.0; });
  };
  EXPECT_THAT(jump(0.0131), HasSubstr("the position of joint 2 jumped by 0.013 rad within 1.000"));
  EXPECT_THAT(jump(-0.0131), HasSubstr("joint 2 jumped by -0.013 rad"));
  EXPECT_THAT(jump(0.0129), testing::Not(HasSubstr("jumped")));  // 3 · 1 rad/s · 1 ms + 10 mrad
}

// Positions follow for a third of a speed that is too high, in its direction.
TEST(MotionCheck, NamesASpeedThatPositionsDoNotHave) {
  const auto race = [](double said, double had) {
    return cause_of([had](double t) { return had * std::max(0.0, t - 0.5); },
                    [said](double t) { return t < 0.5005 ? 0.0 : said; });
  };
  EXPECT_THAT(race(3.1, 0.0), HasSubstr("joint 2 turns at 3.10 rad/s, which its positions"));
  EXPECT_THAT(race(-3.1, 0.9), HasSubstr("joint 2 turns at -3.10 rad/s"));
  EXPECT_THAT(race(3.1, -1.2), HasSubstr("joint 2 turns at 3.10 rad/s"));
  EXPECT_THAT(race(2.9, 0.0), testing::Not(HasSubstr("which its positions contradict")));
  EXPECT_EQ(race(-3.1, -3.1), "");
  // What its positions did 4 ms before confirms no speed.
  EXPECT_THAT(
      cause_of([](double t) { return 0.1 * t; }, [](double t) { return t < 0.5005 ? 0.1 : 3.1; }),
      HasSubstr("joint 2 turns at 3.10 rad/s, which its positions"));
  // Every second reading of the positions is a new one.
  EXPECT_EQ(cause_of([](double t) { return 6.4e-3 * std::floor(500.0 * t + 1e-6); },
                     [](double t) { return 3.2 + 1e-6 * std::sin(1e4 * t); }),
            "");
}

// Speeds that never stay the same, as noise is on them.
TEST(MotionCheck, NamesPositionsThatDriftFromWhereTheSpeedLed) {
  const auto drift = [](double rate) {
    return cause_of([rate](double t) { return rate * t; },
                    [](double t) { return 1e-6 * std::sin(1e4 * t); });
  };
  EXPECT_THAT(drift(0.02), HasSubstr("the positions of joint 2 contradict its speed"));
  EXPECT_THAT(drift(-0.02), HasSubstr("they are -0.008 rad away"));
  EXPECT_EQ(drift(0.006), "") << "8 mrad/s may go unnoticed";
  // At 1 rad/s a filter of 30 ms may be late by 30 mrad, too: 38 mrad are allowed within 1 s.
  const auto faster = [](double by) {
    return cause_of([by](double t) { return (1.0 + by) * t; },
                    [](double t) { return 1.0 + 1e-6 * std::sin(1e4 * t); });
  };
  EXPECT_EQ(faster(0.055), "");
  EXPECT_THAT(faster(0.065), HasSubstr("the positions of joint 2 contradict its speed"));
}

TEST(MotionCheck, NamesATorqueThatMovesNothingAndNothingElseHolds) {
  const auto still = [](double torque, double external) {
    return cause_of([](double) { return 0.3; }, [](double) { return 0.0; }, torque, external);
  };
  EXPECT_THAT(still(5.0, 0.0), HasSubstr("although 50 % of a joint's largest torque ask it to"));
  EXPECT_THAT(still(-5.0, 2.0), HasSubstr("although 30 % of a joint's largest torque ask it to"));
  EXPECT_EQ(still(5.0, 4.5), "") << "the canvas holds it";
  EXPECT_EQ(still(0.9, 0.0), "") << "so may stiction";
}

TEST(MotionCheck, OnlyAStopThatNothingExplainsIsOne) {
  const JointVector speed = JointVector::Ones(2), limit = JointVector::Constant(2, 300.0);
  const JointVector none = JointVector::Zero(2);
  const JointMatrix M = 2.0 * JointMatrix::Identity(2, 2);
  // Readings from the stop until it is named; −1: not within 0.1 s. slows: how long the stop takes
  // [s]; grain: what positions are rounded to [rad]; blow: torque that comes with the stop [Nm].
  const auto named = [&](double v, double slows, double grain, double blow, double before = 0.0) {
    MotionCheck check(speed, limit);
    JointVector q = none;
    double x = 0.0;
    for (int i = 0; i < 300; ++i) {
      const double since = 1e-3 * (i - 200);
      x += 1e-3 * v *
           (since < 0.0 ? std::min(1.0, (i + 1) / 100.0)
                        : std::max(0.0, 1.0 - since / std::max(slows, 1e-9)));
      q[0] = grain > 0.0 ? grain * std::floor(x / grain) : x;
      const JointVector external = JointVector::Constant(2, since <= 0.0 ? before : blow);
      if (check.update(q, nullptr, none, external, 1e-3, &M)) return i - 200;
    }
    return -1;
  };
  EXPECT_EQ(named(0.1, 0.0, 0.0, 0.0), 8);
  EXPECT_EQ(named(0.1, 0.0, 1e-5, 0.0), 8);
  EXPECT_EQ(named(0.01, 0.0, 0.0, 0.0), 8);          // at 5 mm/s
  EXPECT_EQ(named(0.1, 0.1, 0.0, 0.0), -1);          // it slows down
  EXPECT_EQ(named(0.1, 0.0105, 0.0, 0.0), -1);       // quickly, and dry friction keeps it
  EXPECT_EQ(named(0.1, 0.0, 0.0, 250.0), -1);        // a blow can stop it
  EXPECT_EQ(named(0.1, 0.0, 0.0, 250.0, 250.0), 8);  // but not what pushed before
  EXPECT_EQ(named(0.002, 0.0, 0.0, 0.0), -1);        // dry friction can
  EXPECT_EQ(named(0.008, 0.0, 1e-4, 0.0), -1);       // coarse positions
  EXPECT_EQ(named(0.0, 0.0, 0.0, 20.0), -1);         // it stood
  EXPECT_EQ(named(0.0101, 0.0, 1e-5, 0.0), -1);      // rounded, it may have crept
  EXPECT_EQ(named(0.012, 0.0, 1e-5, 0.0), -1);
}

// At 5 mm/s friction can stop each joint, but not three within a millisecond. Unnoticed, the arm
// flies off at 20 rad/s.
TEST(MotionCheck, SlowJointsDoNotStopTogether) {
  const JointVector speed = JointVector::Ones(4), limit = JointVector::Constant(4, 300.0);
  const JointVector none = JointVector::Zero(4);
  const JointMatrix M = 0.1 * JointMatrix::Identity(4, 4);
  // joints: that stop with the first; later: the others, by so many readings; way: of each, a
  // reading.
  const auto named = [&](int joints, int later, double way = 4e-6) {
    MotionCheck check(speed, limit);
    JointVector q = none;
    for (int i = 0; i < 300; ++i) {
      for (int j = 0; j < 4; ++j)
        if (i < 200 + (j < joints ? 0 : later * j)) q[j] += way * std::min(1.0, (i + 1) / 100.0);
      if (check.update(q, nullptr, none, none, 1e-3, &M)) return i - 200;
    }
    return -1;
  };
  EXPECT_EQ(named(4, 0), 7);
  EXPECT_EQ(named(3, 100), 7);
  EXPECT_EQ(named(2, 1), -1);
  // An arm comes to rest so. Seen on a helmet, where a pad's job was ended by it.
  EXPECT_EQ(named(4, 0, 5e-7), -1);
}

// A heavy joint of coarse positions that goes on after two readings was no stop; the light one that
// friction holds beside it is none.
TEST(MotionCheck, AJointThatGoesOnHasNotStopped) {
  const JointVector speed = JointVector::Ones(2), limit = JointVector::Constant(2, 300.0);
  const JointVector none = JointVector::Zero(2);
  JointMatrix M = 2.0 * JointMatrix::Identity(2, 2);
  M(1, 1) = 0.01;
  MotionCheck check(speed, limit);
  JointVector q = none;
  for (int i = 0; i < 300; ++i) {
    const double way = 1e-4 * std::min(1.0, (i + 1) / 100.0);
    if (i < 200 || i >= 202) q[0] += way;
    if (i < 200) q[1] += way;
    ASSERT_FALSE(check.update(q, nullptr, none, none, 1e-3, &M)) << i << " " << check.cause();
  }
}

// Friction that stops a slow joint takes the heavy one along that its inertia is coupled to. Seen
// on a pad's way over the duck: joint 3 came to rest at 0.01 rad/s, and the job was ended.
TEST(MotionCheck, AJointThatTakesAnotherAlongHasStopped) {
  const JointVector speed = JointVector::Ones(2), limit = JointVector::Constant(2, 300.0);
  const JointVector none = JointVector::Zero(2);
  JointMatrix M(2, 2);
  M << 4.0, 1.2, 1.2, 0.6;
  const auto named = [&](double taken_along) {
    MotionCheck check(speed, limit);
    JointVector q = none;
    for (int i = 0; i < 300; ++i) {
      const double begun = std::min(1.0, (i + 1) / 100.0);
      q[0] += 1e-3 * (0.05 * begun - (i < 200 ? 0.0 : taken_along));
      if (i < 200) q[1] -= 1e-3 * 0.01 * begun;
      if (check.update(q, nullptr, none, none, 1e-3, &M)) return true;
    }
    return false;
  };
  EXPECT_FALSE(named(1.2 / 4.0 * 0.01));
  EXPECT_TRUE(named(0.0));
  EXPECT_TRUE(named(-1.2 / 4.0 * 0.01));
}

TEST(MotionCheck, AConstantSpeedThatPositionsContradictIsNamed) {
  const JointVector one = JointVector::Ones(2), none = JointVector::Zero(2);
  // Positions go on at `truly`, rounded to 1e-5 rad, beside a speed that is said.
  const auto cause = [&](double truly, double said) {
    MotionCheck check(one, one);
    JointVector q = none, v = none;
    for (int i = 0; i < 1000; ++i) {
      q[1] = 1e-5 * std::round(1e2 * truly * i);
      v[1] = said;
      if (check.update(q, &v, none, none, 1e-3)) return check.cause();
    }
    return std::string();
  };
  EXPECT_THAT(cause(0.0, 0.05), HasSubstr("joint 2 turns at 0.050 rad/s, but its position"));
  EXPECT_THAT(cause(0.05, 0.0), HasSubstr("speed of joint 2 has been 0.000 rad/s"));
  EXPECT_THAT(cause(0.05, -0.05), HasSubstr("speed of joint 2 has been -0.050 rad/s"));
  EXPECT_EQ(cause(0.05, 0.05), "");
  EXPECT_EQ(cause(0.006, 0.0), "");  // a speed that is rounded to 0.01 rad/s
  EXPECT_EQ(cause(0.0, 0.0), "");
}

TEST(MotionCheck, AJointThatItsTorqueDoesNotMoveIsNamedWhileOthersMove) {
  const JointVector one = JointVector::Ones(2), limit = JointVector::Constant(2, 100.0);
  MotionCheck check(one, limit);
  JointVector q = JointVector::Zero(2), torque = q;
  const JointVector none = q;
  int named = 0;
  for (int i = 1; i < 1000 && named == 0; ++i) {
    q = JointVector::Constant(2, 1e-4 * i);
    q[1] = std::min(q[1], 0.01);       // it has moved
    torque[1] = i < 500 ? 9.0 : 60.0;  // a tenth of the limit may be stiction
    if (check.update(q, nullptr, torque, none, 1e-3)) named = i;
  }
  EXPECT_NEAR(named, 541, 2);  // 20 ms / (0.6 − 0.1)
  EXPECT_THAT(check.cause(), HasSubstr("joint 2 does not move by a bit"));
}

TEST(ReadingMonitor, ADriverThatChecksTheMotionIsNotCheckedAgain) {
  const JointVector one = JointVector::Ones(2), none = JointVector::Zero(2);
  for (const bool checks : {false, true}) {
    DriverInfo driver{2, 1e-3, WrenchReading::none};
    driver.checks_motion = checks;
    ReadingMonitor check(driver, one, one, 0.0);
    ArmState state(2);
    for (int i = 1; i <= 100; ++i) {
      state.time = state.state_time = 1e-3 * i;
      state.q[0] = i < 50 ? 0.0 : 0.02;
      check.update(state, none, none);
    }
    EXPECT_THAT(check.cause(), HasSubstr(checks ? "" : "jumped by 0.020 rad within 1.000 ms"));
    EXPECT_EQ(check.cause().empty(), checks);
  }
}

TEST(ReadingMonitor, AClockAndStampsOutsideItAreNamed) {
  const DriverInfo driver{2, 1e-3, WrenchReading::tip};
  const JointVector one = JointVector::Ones(2), none = JointVector::Zero(2);
  const auto told = [&](const auto& lie) {
    ReadingMonitor check(driver, one, one, 0.002);
    ArmState state(2);
    for (int i = 1; i <= 100; ++i) {
      state.time = state.state_time = state.wrench_time = 1e-3 * i;
      lie(i, &state);
      if (check.update(state, none, none)) return check.cause();
    }
    return check.cause();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(told([](int, ArmState*) {}), "");
  EXPECT_EQ(told([](int, ArmState* s) { s->wrench_time -= 0.5; }), "");
  EXPECT_EQ(told([](int, ArmState* s) { s->wrench_time += 0.02; }), "");
  EXPECT_EQ(told([](int, ArmState* s) { s->wrench_time += 0.05; }),
            "the wrench is stamped 0.050 s ahead of the arm's clock");
  EXPECT_THAT(told([&](int, ArmState* s) { s->wrench_time = nan; }), HasSubstr("stamped nan s"));
  EXPECT_THAT(told([](int, ArmState* s) { s->wrench_time = -1e12; }), HasSubstr("behind"));
  EXPECT_EQ(told([](int, ArmState* s) { s->state_time += 0.05; }),
            "the joint state is stamped 0.050 s ahead of the arm's clock");
  EXPECT_EQ(told([](int i, ArmState* s) { s->time = i < 50 ? s->time : 0.01; }),
            "the arm's clock went back from 0.049 s to 0.010 s");
  EXPECT_EQ(told([](int i, ArmState* s) {
              s->time = s->state_time = s->wrench_time = 1e-3 * std::min(i, 50);
            }),
            "the arm's clock stands still");
  EXPECT_THAT(told([&](int, ArmState* s) { s->time = nan; }), HasSubstr("clock went back"));
  EXPECT_EQ(told([](int i, ArmState* s) {
              s->time = s->state_time = s->wrench_time = 1e-3 * i + (i < 50 ? 0.0 : 0.3);
            }),
            "the arm's clock jumped ahead from 0.049 s to 0.350 s");
}

// The wrench of a sensor while the tip moves by `way` [m] along its normal, or across.
TEST(ReadingMonitor, NamesAWrenchThatStandsStillWhileTheTipMovesAlongTheNormal) {
  DriverInfo driver{1, 1e-3, WrenchReading::tip};
  driver.checks_motion = true;
  const auto says = [&](double force, double way, const Eigen::Vector3d& along, double noise = 0.0,
                        double late = 0.0, bool felt = true, bool is_damped = false) {
    const JointVector one = JointVector::Ones(1);
    ReadingMonitor monitor(driver, one, one, 0.002, felt);
    MadeUpCycle made;
    made.out.n_WD = Eigen::Vector3d::UnitZ();
    made.F_ext[2] = force;
    Verdict said;
    for (int i = 0; i < 200 && !said; ++i) {
      made.state.wrench = made.F_ext;
      made.state.wrench[2] += noise * (i % 2);
      made.arm.X_WE.p = i / 199.0 * way * along;
      const Cycle cycle = made.next();
      made.state.state_time = made.state.time;
      made.state.wrench_time = made.state.time - late;
      said = monitor.judge(cycle, is_damped);
    }
    return said;
  };
  const Eigen::Vector3d n = Eigen::Vector3d::UnitZ();
  const Verdict said = says(5.0, 5.2e-3, n);
  EXPECT_EQ(said.severity, Severity::damp);
  EXPECT_THAT(said.cause, StartsWith("the wrench stands still: the force on the tip is still 5.0"));
  EXPECT_TRUE(says(5.0, -5.2e-3, n));
  EXPECT_TRUE(says(5.0, 5.2e-3, n, 0.0, 0.021)) << "2 ms are the wrench's own";
  EXPECT_FALSE(says(5.0, 4.9e-3, n));
  EXPECT_FALSE(says(5.0, 0.1, Eigen::Vector3d::UnitX())) << "along the surface";
  EXPECT_FALSE(says(0.9, 5.2e-3, n)) << "nothing acts";
  EXPECT_FALSE(says(5.0, 5.2e-3, n, 1e-6));
  EXPECT_FALSE(says(5.0, 5.2e-3, n, 0.0, 0.03)) << "its stamp is old: the law says so";
  EXPECT_FALSE(says(5.0, 5.2e-3, n, 0.0, 0.0, false));
  EXPECT_FALSE(says(60.0, 5.2e-3, n, 0.0, 0.0, true, true)) << "a hand pushes a damped arm";
}

// A torque that a push on the canvas explains asks nothing of the arm.
TEST(ReadingMonitor, TakesThePushForWhatHoldsTheArmWhereNoWrenchIsMeasured) {
  const auto says = [](double push) {
    const DriverInfo driver{1, 1e-3, WrenchReading::none};
    ReadingMonitor monitor(driver, JointVector::Ones(1), JointVector::Constant(1, 10.0), 0.0);
    MadeUpCycle made;
    made.arm.J.setZero(6, 1);
    made.arm.J(2, 0) = -1.0;
    made.out.n_WD = Eigen::Vector3d::UnitZ();
    made.out.push = push;
    made.out.terms(0, kGravity) = 7.0;
    made.out.tau[0] = 12.0;
    Verdict said;
    for (int i = 0; i < 1000 && !said; ++i) {
      const Cycle cycle = made.next();
      made.state.state_time = made.state.time;
      said = monitor.judge(cycle);
    }
    return said;
  };
  EXPECT_FALSE(says(5.0));
  const Verdict said = says(1.0);
  EXPECT_EQ(said.severity, Severity::damp);
  EXPECT_THAT(said.cause, StartsWith("the arm does not move, although 40 %"));
}

}  // namespace
}  // namespace impedraw
