// The integral of the force error: removes a steady force error, stays within its bound, and has no
// after-effect.
#include <algorithm>

#include <gtest/gtest.h>

#include "free_arm.h"

namespace impedraw {
namespace {

using namespace testing_arm;

ImpedanceSettings integrating(const ArmModel& arm, double limit) {
  ImpedanceSettings s = shaped_settings(arm);
  s.observer.enabled = false;
  s.force_integral = {true, 5.0, limit};
  return s;
}

double steady_force(PlaneArm& on) {
  double mean = 0.0;
  for (int i = 0; i < 500; ++i) {
    on.step();
    mean += on.n_W.dot(on.free.F_ext.head<3>()) / 500.0;
  }
  return mean;
}

TEST(ForceIntegral, MendsTheForceThatAWrongModelLeaves) {
  ArmModel arm(kArm);
  ModelErrors heavy;
  heavy.mass_scale = 1.02;
  for (const bool on : {false, true}) {
    ImpedanceSettings s = integrating(arm, 5.0);
    s.force_integral.enabled = on;
    PlaneArm plane(s, 0.2, heavy);
    plane.draw(4000);
    if (on)
      EXPECT_NEAR(steady_force(plane), s.normal_force, 0.01 * s.normal_force);
    else
      EXPECT_GT(std::abs(steady_force(plane) - s.normal_force), 0.05 * s.normal_force)
          << "or there was nothing to mend";
  }
}

// A long error beyond the integral's bound. Once the error ends, the integral decays within its own
// time constant: it did not wind up.
TEST(ForceIntegral, IsBoundedAndDoesNotWindUp) {
  ArmModel arm(kArm);
  const ImpedanceSettings s = integrating(arm, 1.0);
  PlaneArm plane(s, 0.2);
  plane.draw(1500);
  // A false reading: 3 N too little for 5 s.
  const auto lie = [&](double missing) {
    plane.free.measure();
    plane.look();
    plane.free.F_ext.head<3>() -= missing * plane.n_W;
    const JointVector tau = plane.free.control().tau;
    plane.free.move(tau, Wrench::Zero());
    return plane.n_W.dot(plane.free.F_ext.head<3>());
  };
  double most = 0.0;
  for (int i = 0; i < 5000; ++i) most = std::max(most, lie(3.0));
  const double believed = most;
  EXPECT_LT(believed, s.normal_force + 3.0 + s.force_integral.limit + 0.5)
      << "what it is told is missing, and its bound";
  double last = 0.0;
  for (int i = 0; i < 1500; ++i) last = lie(0.0);
  EXPECT_NEAR(last, s.normal_force, 0.05) << "1 N at 5 1/s is gone in a second and a half";
}

TEST(ForceIntegral, IsGoneOutOfContact) {
  ArmModel arm(kArm);
  ModelErrors heavy;
  heavy.mass_scale = 1.02;
  const ImpedanceSettings s = integrating(arm, 5.0);
  PlaneArm plane(s, 0.2, heavy);
  plane.draw(4000);
  plane.free.reference.pen_down = false;
  plane.free.reference.p_WD = plane.p_WS + 0.02 * plane.n_W;
  for (int i = 0; i < 1500; ++i) plane.step();
  // In the air, stiffness holds the tip as without an integral.
  ImpedanceSettings without = s;
  without.force_integral.enabled = false;
  PlaneArm other(without, 0.2, heavy);
  other.draw(4000);
  other.free.reference.pen_down = false;
  other.free.reference.p_WD = plane.free.reference.p_WD;
  for (int i = 0; i < 1500; ++i) other.step();
  EXPECT_LT((plane.free.world.state().X_WE.p - other.free.world.state().X_WE.p).norm(), 2e-5);
}

}  // namespace
}  // namespace impedraw
