// What brings a run to its end: damping without belief, and waits that add up.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/run/driven_arm.h"
#include "impedraw/run/monitors/canvas_monitor.h"

namespace impedraw {
namespace {

constexpr double kCycle = 1e-3;

ImpedanceTorque of_two_joints() {
  ImpedanceTorque out;
  out.tau = JointVector::Zero(2);
  out.terms.setZero(2, kTorqueTerms);
  return out;
}

// Two joints that turn together: M v at 20/s.
TEST(DampedEnd, DampsAgainstTheSpeedWithinTheLimitsAndKeepsTheWeight) {
  JointMatrix M = JointMatrix::Zero(2, 2);
  M << 1.0, 0.5, 0.5, 4.0;
  ImpedanceTorque out = of_two_joints();
  out.push = 5.0;
  out.status.torque_limited = true;
  out.terms.setConstant(3.0);
  out.terms.col(kGravity) << 7.0, -2.0;
  JointVector v(2), most(2);
  v << 0.1, -1.0;
  most << 30.0, 30.0;
  DampedEnd end;
  end.damp(M, v, most, kCycle, &out);
  EXPECT_NEAR(out.tau[0], 7.0 - 20.0 * (0.1 - 0.5), 1e-12);
  EXPECT_NEAR(out.tau[1], 30.0, 1e-12);  // −2 + 79, limited
  EXPECT_NEAR(out.terms.col(kImpedance)[1], -20.0 * (0.05 - 4.0), 1e-12);
  EXPECT_EQ(out.terms.col(kGravity)[0], 7.0);
  EXPECT_EQ(out.push, 0.0);
  EXPECT_FALSE(out.status.torque_limited);
  EXPECT_EQ(out.mode, ContactMode::free);
}

TEST(DampedEnd, IsOverOnceAllJointsAreCalmOrAfterItsTime) {
  const JointMatrix M = JointMatrix::Identity(2, 2);
  ImpedanceTorque out = of_two_joints();
  JointVector fast(2), calm(2);
  fast << 0.0, -1.01 * kDampedSpeed;
  calm << 0.99 * kDampedSpeed, -0.99 * kDampedSpeed;
  DampedEnd end;
  EXPECT_FALSE(end.over(fast));
  EXPECT_TRUE(end.over(calm));
  int cycles = 0;
  for (; !end.over(fast) && cycles < 1000; ++cycles)
    end.damp(M, fast, JointVector::Constant(2, 100.0), kCycle, &out);
  EXPECT_NEAR(cycles * kCycle, kDampTime, 1.5 * kCycle);
}

TEST(WaitMonitor, AddsUpUntilAStrokeIsDrawn) {
  WaitMonitor wait(0.01);
  const auto cycles = [&wait](int n, bool waits, bool draws) {
    int too_long = 0;
    for (int i = 0; i < n; ++i) too_long += wait.update(waits, draws, kCycle);
    return too_long;
  };
  EXPECT_EQ(cycles(8, true, false), 0);
  EXPECT_EQ(cycles(50, false, false), 0);  // travels: nothing is forgotten
  EXPECT_NEAR(wait.waited(), 8e-3, 1e-12);
  EXPECT_GE(cycles(4, true, false), 1);
  EXPECT_EQ(cycles(1, false, false), 0);  // ends no run that goes on
  EXPECT_EQ(cycles(1, false, true), 0);
  EXPECT_EQ(wait.waited(), 0.0);
  EXPECT_EQ(cycles(8, true, false), 0);
}

}  // namespace
}  // namespace impedraw
