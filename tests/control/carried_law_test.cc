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

}  // namespace
}  // namespace impedraw
