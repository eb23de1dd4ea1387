// The whole law on a canvas that moves, against mechanics: a canvas at constant velocity changes
// nothing, and a turntable pulls what rests on it towards its axis.
#include <gtest/gtest.h>

#include "any_arm.h"
#include "impedraw/control/impedance.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
using testing_arm::AnyArm;

ImpedanceSettings unobserved() {
  ImpedanceSettings s;
  s.observer.enabled = false;
  s.null_space.stiffness = Eigen::VectorXd::Zero(7);  // damps the joints, not the tip on its canvas
  return s;
}

// A pen in contact with a plane through its tip.
struct Drawing {
  ArmTerms arm;
  TipReference plan;
  SurfaceEstimate surface;
  Wrench F_ext = Wrench::Zero();
  ImpedanceController controller{unobserved(), 7};

  explicit Drawing(AnyArm& any) : arm(any.terms(0.0)) {
    plan.p_WD = arm.X_WE.p;
    plan.n_WD = surface.n_W = -arm.X_WE.R.col(2);
    plan.pen_down = true;
    surface.status = SurfaceStatus::ok;
    surface.distance = 0.0;
    F_ext.head<3>() = 5.0 * surface.n_W;
  }
  ImpedanceTorque settle(const FrameMotion* carrier) {
    for (int i = 0; i < 1500; ++i) controller.step(arm, plan, surface, F_ext, {}, carrier);
    return controller.step(arm, plan, surface, F_ext, {}, carrier);
  }
};

TEST(CarriedLaw, ACanvasAtConstantVelocityChangesNothing) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE(seed);
    AnyArm any(seed);
    Drawing standing(any);
    const Vector3d n = standing.surface.n_W;
    standing.plan.v_WD = 0.05 * n.unitOrthogonal();
    standing.arm.V_WE.head<3>() = 0.04 * n.unitOrthogonal();
    standing.F_ext.head<3>() += any.vector(1.0);
    Drawing moving = standing;
    FrameMotion carrier;
    carrier.v = any.vector(0.05);
    moving.plan.v_WD += carrier.v;
    moving.arm.V_WE.head<3>() += carrier.v;
    const ImpedanceTorque a = standing.settle(nullptr), b = moving.settle(&carrier);
    ASSERT_EQ(b.mode, ContactMode::contact);
    EXPECT_LT((a.terms - b.terms).norm(), 1e-9);
    EXPECT_LT((a.tau - b.tau).norm(), 1e-9);
  }
}

TEST(CarriedLaw, ATurntablePullsWhatRestsOnItTowardsItsAxis) {
  AnyArm any(3);
  Drawing pen(any);
  const Vector3d n = pen.surface.n_W, arm_of_turn = 0.2 * n.unitOrthogonal();
  FrameMotion table;
  table.X_WK.p = pen.arm.X_WE.p - arm_of_turn;
  table.w = 1.5 * n;
  TipReference rests;
  rests.p_WD = arm_of_turn;
  rests.n_WD = n;
  rests.pen_down = true;
  pen.plan = carried(rests, table);
  pen.arm.V_WE.head<3>() = table.velocity_at(pen.arm.X_WE.p);
  const ImpedanceTorque out = pen.settle(&table);
  ASSERT_EQ(out.mode, ContactMode::contact);
  OperationalSpace space;
  space.update(pen.arm);
  const Vector6 Vdot = space.inverse_inertia() * space.project_to_tip(out.terms.col(kFeedforward));
  EXPECT_LT((Vdot.head<3>() + 1.5 * 1.5 * arm_of_turn).norm(), 1e-9);
}

// The carrier is believed to stand still; the tip in contact shows that the surface rises.
TEST(CarriedLaw, ARisingSurfaceIsFollowedAndReported) {
  AnyArm any(4);
  Drawing pen(any);
  const Vector3d n = pen.surface.n_W;
  const FrameMotion believed;
  const ImpedanceTorque still = pen.settle(&believed);
  pen.arm.V_WE.head<3>() = 0.03 * n;
  const ImpedanceTorque out = pen.settle(&believed);
  EXPECT_NEAR(out.rise, 0.03, 1e-9);
  EXPECT_LT((out.terms.col(kImpedance) - still.terms.col(kImpedance)).norm(), 1e-6)
      << "the damping along n acts on the motion that the surface lacks";
}

// The share of the normal falls while a joint is fast.
TEST(CarriedLaw, OnACarrierTheNormalComesFirstWhereTorqueLacksUnlessAJointIsFast) {
  AnyArm any(5);
  Drawing pen(any);
  pen.arm.v = JointVector::Zero(7);
  pen.arm.v[3] = 0.3;
  const FrameMotion stands;
  const auto tau = [&](double share_of_speed, const FrameMotion* carrier) {
    ImpedanceSettings s = unobserved();
    s.limits.torque_rate = Eigen::VectorXd::Constant(7, 400.0);
    s.limits.joint_speed = Eigen::VectorXd::Constant(7, 0.3 / share_of_speed);
    ImpedanceController controller(s, 7);
    ArmTerms arm = pen.arm;
    controller.step(arm, pen.plan, pen.surface, pen.F_ext, {}, carrier);
    arm.g[2] += 3.0;
    return controller.step(arm, pen.plan, pen.surface, pen.F_ext, {}, carrier).tau;
  };
  const JointVector first = tau(0.05, &stands), last = tau(0.05, nullptr);
  EXPECT_GT((first - last).norm(), 0.01);
  EXPECT_LT((tau(0.29, &stands) - first).norm(), 1e-9);
  EXPECT_LT((tau(0.61, &stands) - last).norm(), 1e-9);
  EXPECT_GT((tau(0.45, &stands) - first).norm(), 1e-3);
  EXPECT_GT((tau(0.45, &stands) - last).norm(), 1e-3);
}

TEST(CarriedLaw, TheFrictionOfThePlansMotionIsFedForwardAsAForceAtTheTip) {
  AnyArm any(6);
  Drawing pen(any);
  const Vector3d along = pen.surface.n_W.unitOrthogonal();
  pen.plan.v_WD = 0.05 * along;
  const auto feedforward = [&](double coefficient) {
    ImpedanceSettings s = unobserved();
    s.wrench = WrenchFeedback::none;
    s.inertia = InertiaShaping::natural;
    s.friction.feedforward = coefficient;
    pen.controller = ImpedanceController(s, 7);
    while (pen.controller.step(pen.arm, pen.plan, pen.surface, pen.F_ext, {}).mode !=
           ContactMode::contact) {
    }
    return JointVector(pen.settle(nullptr).terms.col(kFeedforward));
  };
  Vector6 F = Vector6::Zero();
  F.head<3>() = 0.4 * ImpedanceSettings().normal_force * along;
  EXPECT_LT((feedforward(0.4) - feedforward(0.0) - pen.arm.J.transpose() * F).norm(), 0.01);
}

// A soft tip gives way as the push builds up after the touch.
TEST(CarriedLaw, TheInksPlaceFollowsThePushThatActs) {
  AnyArm any(7);
  Drawing pen(any);
  ImpedanceSettings s = unobserved();
  s.tip.stiffness = 5e3;
  pen.controller = ImpedanceController(s, 7);
  const auto give = [&] {
    const ImpedanceTorque& out = pen.controller.step(pen.arm, pen.plan, pen.surface, pen.F_ext, {});
    return pen.surface.n_W.dot(pen.plan.p_WD - out.p_WD);
  };
  for (int i = 0; i < 2; ++i) give();
  const double whole = s.normal_force / s.tip.stiffness;
  EXPECT_LT(give(), 0.3 * whole);
  for (int i = 0; i < 500; ++i) give();
  EXPECT_NEAR(give(), whole, 1e-3 * whole);
}

}  // namespace
}  // namespace impedraw
