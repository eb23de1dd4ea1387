// The forces at the tip, each against its closed form: desired inertia and damping, the push with
// its integral, the handover at a switch, and friction.
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "any_arm.h"
#include "dense_algebra.h"
#include "impedraw/control/handover.h"
#include "impedraw/control/normal_push.h"
#include "impedraw/control/tip_friction.h"
#include "impedraw/control/tip_impedance.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
using testing_arm::AnyArm;

Matrix6 matrix_of(const TipGain& gain, const Vector3d& n) {
  Matrix6 G = Matrix6::Zero();
  G.topLeftCorner<3, 3>() = gain.linear.matrix(n);
  G.bottomRightCorner<3, 3>() = gain.angular.matrix(n);
  return G;
}

TEST(TipImpedance, EveryModeHasTheDampingRatioAndForcesReachTheDesiredInertia) {
  for (const InertiaShaping inertia : {InertiaShaping::natural, InertiaShaping::scaled,
                                       InertiaShaping::shaped, InertiaShaping::light_normal}) {
    ImpedanceSettings s;
    s.inertia = inertia;
    s.inertia_scale = 2.5;
    TipImpedance impedance(s);
    AnyArm any(1);
    for (int i = 0; i < 10; ++i) {
      const ArmTerms arm = any.terms();
      const Vector3d n = any.direction();
      OperationalSpace space;
      space.update(arm);
      impedance.update(space, n);
      const Matrix6 Lambda = testing_arm::operational_inertia(arm.J, arm.M);
      const Matrix6 S = matrix_of({{1.0, std::sqrt(2.5)}, {1.0, 1.0}}, n);
      const Matrix6 M_d = inertia == InertiaShaping::shaped         ? matrix_of(s.shaped_inertia, n)
                          : inertia == InertiaShaping::scaled       ? Matrix6(2.5 * Lambda)
                          : inertia == InertiaShaping::light_normal ? Matrix6(S * Lambda * S)
                                                                    : Lambda;
      Matrix6 B;
      for (int k = 0; k < 6; ++k) B.col(k) = impedance.damp(Vector6::Unit(k));
      const testing_arm::Modes modes = testing_arm::modes(matrix_of(s.damping_stiffness(), n), M_d);
      const Eigen::MatrixXd modal = modes.Q.transpose() * B * modes.Q;
      for (int k = 0; k < 6; ++k)
        EXPECT_NEAR(modal(k, k), 2.0 * s.damping_ratio * std::sqrt(modes.omega_squared[k]),
                    4e-3 * modal(k, k));
      const Vector6 F = any.wrench(5.0);
      EXPECT_LT((impedance.damp(impedance.follow(F)) - F).norm(), 1e-9);
      EXPECT_LT((M_d * testing_arm::inverse(Lambda) * impedance.to_arm(space, F) - F).norm(), 1e-8);
    }
  }
}

// Under a stiff contact: s of M_d⁻¹ and of B are those of the arm's own inertia.
TEST(TipImpedance, AShareIsTheArmsOwn) {
  constexpr double kOwn = 0.75;
  ImpedanceSettings natural;
  natural.inertia = InertiaShaping::natural;
  for (const InertiaShaping inertia :
       {InertiaShaping::scaled, InertiaShaping::shaped, InertiaShaping::light_normal}) {
    ImpedanceSettings s;
    s.inertia = inertia;
    s.inertia_scale = 0.4;
    TipImpedance impedance(s), light(s), own(natural);
    AnyArm any(4);
    const ArmTerms arm = any.terms();
    const Vector3d n = any.direction();
    OperationalSpace space;
    space.update(arm);
    impedance.update(space, n, kOwn);
    light.update(space, n);
    own.update(space, n);
    const Vector6 F = any.wrench(5.0);
    const auto mixed = [&](const Vector6& a, const Vector6& b) -> Vector6 {
      return (1.0 - kOwn) * a + kOwn * b;
    };
    EXPECT_LT((impedance.to_arm(space, F) - mixed(light.to_arm(space, F), F)).norm(), 1e-9);
    EXPECT_LT((impedance.damp(F) - mixed(light.damp(F), own.damp(F))).norm(), 1e-9);
    EXPECT_LT((impedance.follow(F) - mixed(light.follow(F), own.follow(F))).norm(), 1e-9);
  }
}

TEST(TipImpedance, ReportsDampingThatTheSampledLoopDoesNotBear) {
  ImpedanceSettings s;
  s.inertia = InertiaShaping::natural;
  AnyArm any(2);
  const ArmTerms arm = any.terms();
  OperationalSpace space;
  space.update(arm);
  TipImpedance impedance(s);
  impedance.update(space, Vector3d::UnitZ());
  EXPECT_FALSE(impedance.at_limit());
  impedance.retune({{2e6, 2e6}, {2e4, 2e4}});
  impedance.update(space, Vector3d::UnitZ());
  EXPECT_TRUE(impedance.at_limit());
}

TEST(Handover, TheForceIsContinuousAtASwitchAndTheDifferenceDecays) {
  constexpr double kTime = 0.04, kStep = 1e-3;
  Handover handover(kTime, kStep);
  AnyArm any(3);
  const Vector6 F_1 = any.wrench(5.0), push_1 = any.wrench(1.0), F_2 = any.wrench(5.0),
                push_2 = any.wrench(5.0);
  EXPECT_EQ(handover.smooth(ContactMode::free, F_1, push_1), F_1);
  const Vector6 jump = F_1 + push_1 - F_2 - push_2;
  double left = 1.0;
  for (int i = 0; i < 100; ++i) {
    EXPECT_LT((handover.carried() - (i > 0 ? left : 0.0) * jump).norm(), 1e-12);
    const Vector6 sum = handover.smooth(ContactMode::contact, F_2, push_2) + push_2;
    EXPECT_LT((sum - F_2 - push_2 - left * jump).norm(), 1e-12);
    left *= 1.0 - kStep / kTime;
  }
}

TEST(Handover, AfterAResetTheForceStartsAtOnceOrFromZero) {
  Handover handover(0.04, 1e-3);
  const Vector6 F = Vector6::Ones();
  handover.reset(false);
  EXPECT_EQ(handover.smooth(ContactMode::free, F, Vector6::Zero()), F);
  handover.reset(true);
  EXPECT_EQ(handover.smooth(ContactMode::free, F, Vector6::Zero()), Vector6(Vector6::Zero()));
}

// In contact, with a normal that is felt to lean.
Contact touching(AnyArm& any) {
  Contact contact;
  contact.mode = ContactMode::contact;
  contact.n = contact.n_T = any.direction();
  contact.n_C = (contact.n + 0.3 * any.direction()).normalized();
  return contact;
}

TEST(NormalPush, IntegratesTheErrorOfThePresentPushWithinItsBound) {
  ImpedanceSettings s;
  s.force_integral = {true, 2.0, 0.5};
  AnyArm any(4);
  NormalPush push(s);
  Contact contact = touching(any);
  contact.force = s.normal_force;
  const Vector3d n = contact.n, carried = 1.5 * n;
  Wrench F_ext = Wrench::Zero();
  F_ext.head<3>() = 3.0 * n + n.unitOrthogonal();
  const double asked = s.normal_force * n.dot(contact.n_C);
  const auto pushed = [&](bool frozen) {
    return -n.dot(push.update(contact, F_ext, carried, frozen, 0.1).head<3>());
  };
  for (int i = 1; i <= 100; ++i)
    ASSERT_NEAR(pushed(false), asked + i * 1e-3 * 2.0 * (asked - 1.5 - 3.0), 1e-12);
  const double before = pushed(true);
  EXPECT_NEAR(pushed(true), before, 1e-15) << "frozen";
  EXPECT_EQ(push.desired(), s.normal_force);
  EXPECT_NEAR(push.built_up(), s.normal_force - 1.5, 1e-12);
  F_ext.setZero();
  for (int i = 0; i < 1000; ++i) pushed(false);
  EXPECT_NEAR(pushed(false), asked + 0.5, 1e-12) << "bounded";
  contact.mode = ContactMode::approach;
  EXPECT_EQ(pushed(false), 0.0) << "forgotten out of contact";
  EXPECT_EQ(push.desired(), 0.0);
  EXPECT_EQ(push.built_up(), 0.0);
  contact.mode = ContactMode::free;
  EXPECT_EQ(push.update(contact, F_ext, carried, false, 0.1), Vector6(Vector6::Zero()));
}

TEST(NormalPush, FollowsACommandAsFastAsItIsTold) {
  ImpedanceSettings s;
  s.force_integral.enabled = false;
  AnyArm any(4);
  NormalPush push(s);
  Contact contact = touching(any);
  const auto after = [&](double force, int steps, double fastest = 0.25) {
    contact.force = force;
    for (int i = 0; i < steps; ++i)
      push.update(contact, Wrench::Zero(), Vector3d::Zero(), false, fastest);
    return push.desired();
  };
  EXPECT_EQ(after(5.0, 1), 5.0) << "at the touch the handover makes it grow";
  EXPECT_EQ(after(10.0, 4), 6.0);
  EXPECT_EQ(after(10.0, 100), 10.0);
  EXPECT_EQ(after(2.0, 8), 8.0);
  EXPECT_EQ(after(2.0, 1, std::numeric_limits<double>::infinity()), 2.0);
  contact.mode = ContactMode::approach;
  EXPECT_EQ(after(2.0, 1), 0.0);
  contact.mode = ContactMode::contact;
  EXPECT_EQ(after(5.0, 1), 5.0);
  push.reset();
  EXPECT_EQ(after(8.0, 1), 8.0);
}

TEST(TipFriction, ExplainsCoulombFrictionAndAWrongNormalAndLeavesTheRest) {
  ImpedanceSettings s;
  s.friction.normal_error_deg = 10.0;
  const TipFriction friction(s);
  AnyArm any(5);
  for (int i = 0; i < 50; ++i) {
    Contact contact = touching(any);
    const Vector3d n = contact.n, along = n.cross(any.direction()).normalized(),
                   side = n.cross(along);
    contact.v = 0.3 * along + any.number(-0.1, 0.1) * n;
    const double smooth = 0.3 / std::hypot(0.3, s.friction.fade_speed), f_n = 5.0;
    const auto explained = [&](double against, double aside) {
      Wrench F_ext = Wrench::Zero();
      F_ext.head<3>() = f_n * n - against * along + aside * side;
      return Vector3d(friction.explained(contact, F_ext).head<3>());
    };
    const double most = s.friction.coefficient * f_n;
    EXPECT_NEAR(explained(0.9 * most, 0.0).dot(along), -0.9 * most, 1e-3);
    EXPECT_NEAR(explained(0.9 * most, 0.0).dot(n), 0.0, 1e-12);
    const double tangent = std::tan(10.0 * std::numbers::pi / 180.0) * f_n;
    EXPECT_NEAR(explained(0.0, 0.5 * tangent).dot(side), 0.5 * tangent * smooth, 1e-6);
    EXPECT_NEAR(explained(0.0, 4.0 * tangent).dot(side), tangent, 1e-6);
    contact.mode = ContactMode::approach;
    EXPECT_EQ(explained(most, 0.0), Vector3d(Vector3d::Zero()));
  }
}

TEST(TipFriction, FeedforwardActsAlongTheMotionOnTheCarrier) {
  ImpedanceSettings s;
  s.wrench = WrenchFeedback::none;
  s.inertia = InertiaShaping::natural;
  s.friction.feedforward = 0.4;
  const TipFriction friction(s);
  AnyArm any(6);
  Contact contact = touching(any);
  contact.force = 3.0;
  contact.v_K = any.vector(0.2);
  const Vector3d along = contact.n.unitOrthogonal(), v = contact.v_K + 0.1 * along;
  const double smooth = 0.1 / std::hypot(0.1, s.friction.fade_speed);
  EXPECT_LT((friction.feedforward(contact, v) - 0.4 * 3.0 * smooth * along).norm(), 1e-12);
  EXPECT_EQ(friction.feedforward(contact, contact.v_K).norm(), 0.0);
  contact.mode = ContactMode::free;
  EXPECT_EQ(friction.feedforward(contact, v).norm(), 0.0);
}

}  // namespace
}  // namespace impedraw
