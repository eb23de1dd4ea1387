// The closed loop on the simulated arm: the desired mass-spring-damper, gravity counted once, and
// safe reactions.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "free_arm.h"
#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using namespace testing_arm;

ImpedanceSettings soft(ImpedanceSettings s) {
  s.stiffness = {{300.0, 200.0}, {20.0, 0.0}};
  s.reference_stiffness = {{300.0, 200.0}, {20.0, 2.0}};
  return s;
}

// x of m ẍ + b ẋ + k (x − x_0) = 0 from rest, under-damped.
double response(double t, double m, double k, double zeta, double x_0) {
  const double w = std::sqrt(k / m), wd = w * std::sqrt(1.0 - zeta * zeta);
  return x_0 *
         (1.0 - std::exp(-zeta * w * t) * (std::cos(wd * t) + zeta * w / wd * std::sin(wd * t)));
}

TEST(ClosedLoop, AShapedTipIsTheWantedMassOnASpring) {
  ArmModel arm(kArm);
  ImpedanceSettings s = soft(shaped_settings(arm));
  s.shaped_inertia.linear.normal = 3.0;  // so soft, less would be refused
  for (const bool along_normal : {false, true}) {
    FreeArm free(s);
    const Eigen::Vector3d direction =
        along_normal ? free.reference.n_WD : free.reference.n_WD.unitOrthogonal();
    const Eigen::Vector3d start = free.reference.p_WD;
    const double x_0 = 0.01, m = along_normal ? s.shaped_inertia.linear.normal
                                              : s.shaped_inertia.linear.tangent;
    const double k = along_normal ? s.stiffness.linear.normal : s.stiffness.linear.tangent;
    free.reference.p_WD += x_0 * direction;
    for (int i = 0; i < 1000; ++i) {
      const Eigen::Vector3d moved = free.world.state().X_WE.p - start;
      ASSERT_NEAR(moved.dot(direction), response(i * 1e-3, m, k, s.damping_ratio, x_0), 0.01 * x_0)
          << "at " << i << " ms";
      ASSERT_LT((moved - direction * direction.dot(moved)).norm(), 0.01 * x_0)
          << "the axes are decoupled";
      free.step();
    }
  }
}

TEST(ClosedLoop, AMeasuredPushMovesTheWantedMass) {
  ArmModel arm(kArm);
  double worst[2];
  for (const bool fine : {false, true}) {
    ImpedanceSettings s = soft(shaped_settings(arm));
    s.timing.dt = s.timing.wrench_delay = s.timing.loop_delay = fine ? 0.25e-3 : 1e-3;
    s.stability_check.contact_stiffness_max =
        5e3;  // with this low inertia, a stiffer tip would be refused
    s.stiffness.linear = {50.0, 50.0};
    FreeArm free(s);
    const Eigen::Vector3d direction = free.reference.n_WD.unitOrthogonal(),
                          start = free.reference.p_WD;
    const double F = 1.0, k = s.stiffness.linear.tangent, x_0 = F / k;
    worst[fine] = 0.0;
    for (double t = 0.0; t < 1.0; t += s.timing.dt) {
      const double x = direction.dot(free.world.state().X_WE.p - start);
      worst[fine] = std::max(worst[fine], std::abs(x - response(t, s.shaped_inertia.linear.tangent,
                                                                k, s.damping_ratio, x_0)) /
                                              x_0);
      free.step(F * direction);
    }
  }
  // The remaining error is due to the wrench's age of one step: at first the push meets the arm's
  // own inertia.
  EXPECT_LT(worst[1], 0.01);
  EXPECT_LT(worst[0], 0.025);
  EXPECT_NEAR(worst[0] / worst[1], 4.0, 1.0);
}

TEST(ClosedLoop, ANaturalTipIsTheArmsOwnInertiaOnASpring) {
  ArmModel arm(kArm);
  ImpedanceSettings s = soft(natural_settings(arm));
  // the arm's inertia about the pen is small: keep that mode slow compared with the step
  s.stiffness.angular.tangent = 5.0;
  s.reference_stiffness.angular = {5.0, 0.3};
  FreeArm free(s);
  const Eigen::Vector3d start = free.reference.p_WD;
  const Eigen::Matrix3d R_start = free.terms.X_WE.R;
  OperationalSpace space;
  space.update(free.terms);
  const Matrix6 A = space.inverse_inertia();
  Matrix6 K = Matrix6::Zero(), K_damping = Matrix6::Zero();
  K.topLeftCorner<3, 3>() = s.stiffness.linear.matrix(free.reference.n_WD);
  K.bottomRightCorner<3, 3>() = s.stiffness.angular.matrix(free.reference.n_WD);
  K_damping = K;
  K_damping.bottomRightCorner<3, 3>() = s.reference_stiffness.angular.matrix(free.reference.n_WD);
  ModalDamping modal;
  modal.design(space.inverse_inertia_factor(), K_damping.topLeftCorner<3, 3>(),
               K_damping.bottomRightCorner<3, 3>(), s.damping_ratio);
  Matrix6 B;
  for (int i = 0; i < 6; ++i) B.col(i) = modal.apply(space.inertia_factor(), Vector6::Unit(i));
  // Small motion, so that Λ stays: the reference is the linear 6-D oscillator, integrated finely.
  Vector6 x = Vector6::Zero(), x_dot = Vector6::Zero(), x_D = Vector6::Zero();
  x_D.head<3>() = Eigen::Vector3d(1e-3, -5e-4, 8e-4);
  free.reference.p_WD += x_D.head<3>();
  for (int i = 0; i < 600; ++i) {
    const Pose& X = free.world.state().X_WE;
    ASSERT_LT((X.p - start - x.head<3>()).norm(), 0.01 * x_D.norm()) << "at " << i << " ms";
    const Eigen::AngleAxisd turned(X.R * R_start.transpose());
    ASSERT_LT((turned.angle() * turned.axis() - x.tail<3>()).norm(), 6e-5)
        << "[rad] at " << i << " ms; the sampled loop lags the continuous one by a step";
    free.step();
    for (int k = 0; k < 100; ++k) {
      x_dot += 1e-5 * A * (K * (x_D - x) - B * x_dot);
      x += 1e-5 * x_dot;
    }
  }
}

TEST(ClosedLoop, HoldsStillUnderGravityWithoutDrift) {
  ArmModel arm(kArm);
  for (const ImpedanceSettings& s : {shaped_settings(arm), natural_settings(arm)}) {
    FreeArm free(s);
    const Eigen::Vector3d start = free.reference.p_WD;
    for (int i = 0; i < 2000; ++i) free.step();
    EXPECT_LT((free.world.state().X_WE.p - start).norm(), 1e-9);
  }
}

TEST(ClosedLoop, GravityIsCountedOnce) {
  ArmModel arm(kArm);
  FreeArm free(shaped_settings(arm));
  const ImpedanceTorque& out = free.step();
  // At rest on the reference in the rest posture, the torque is exactly the gravity
  // torque.
  EXPECT_LT((out.tau - free.terms.g).norm(), 1e-9);
  EXPECT_LT((out.terms.col(kGravity) - free.terms.g).norm(), 1e-12);
  EXPECT_LT((out.terms.rowwise().sum() - out.tau).norm(), 1e-12);
}

TEST(ClosedLoop, TheNullSpaceMovesTheElbowAndNotTheTip) {
  ArmModel arm(kArm);
  ImpedanceSettings s = shaped_settings(arm);
  s.null_space.q_0[2] += 0.6;
  FreeArm free(s);
  const Eigen::Vector3d start = free.reference.p_WD;
  double away = 0.0;
  const double before = free.world.state().q[2];
  for (int i = 0; i < 2000; ++i) {
    free.step();
    away = std::max(away, (free.world.state().X_WE.p - start).norm());
  }
  EXPECT_GT(std::abs(free.world.state().q[2] - before), 0.02);
  EXPECT_LT(away, 2e-5);
}

// At rest the law commands the moment K e, where e is the rotation from pen axis to reference: the
// shortest, about the axis normal to both, with its full angle up to half a turn.
TEST(ClosedLoop, TurnsThePenOnTheShortWayUpToHalfATurn) {
  ArmModel arm(kArm);
  ImpedanceSettings s = soft(shaped_settings(arm));
  s.inertia = InertiaShaping::natural;  // M_d = Λ: the term's wrench at the tip is K e
  s.limits.turn_speed = 50.0;           // the limit on turning, not to scale K e
  s.stiffness.angular.tangent *= 0.01;
  const double k = s.stiffness.angular.tangent;
  constexpr double kPi = std::numbers::pi;
  for (const double angle : {0.01, 1.0, 1.7, 3.1, kPi, 2.0 * kPi - 3.1, -3.1}) {
    SCOPED_TRACE(angle);
    FreeArm turned(s);
    const Eigen::Vector3d axis = turned.reference.n_WD.unitOrthogonal();
    turned.reference.n_WD = Eigen::AngleAxisd(angle, axis) * turned.reference.n_WD;
    const ImpedanceTorque& out = turned.step();
    EXPECT_TRUE(out.status.ok() || out.status.torque_limited);
    EXPECT_TRUE((out.tau.cwiseAbs().array() <= arm.limits().torque.array() + 1e-9).all());
    OperationalSpace space;
    space.update(turned.terms);
    const Vector6 F = space.project_to_tip(out.terms.col(kImpedance));
    EXPECT_LT(F.head<3>().norm(), 1e-7) << "the tip is where it is asked to be";
    const Eigen::Vector3d e = F.tail<3>() / k;
    EXPECT_NEAR(e.dot(turned.terms.X_WE.R.col(2)), 0.0, 1e-9);
    if (std::abs(angle) == kPi)  // both senses are equally short, about any axis normal to the pen
      EXPECT_NEAR(e.norm(), kPi, 1e-9);
    else
      EXPECT_LT((e - (angle > kPi ? angle - 2.0 * kPi : angle) * axis).norm(), 1e-9);
  }
}

TEST(ClosedLoop, PassesASingularPostureWithBoundedTorque) {
  ArmModel arm(kArm);
  JointVector q(7);
  q << 0.0, 0.9, 0.0, -0.6, 0.0, 0.5, 0.0;
  ImpedanceSettings s = shaped_settings(arm);
  s.null_space.q_0 = q;
  FreeArm free(s, q);
  const Eigen::Vector3d outward = Eigen::Vector3d(free.reference.p_WD.x(), 0.0,
                                                  free.reference.p_WD.z() - 0.36)
                                      .normalized(),
                        start = free.reference.p_WD;
  bool told = false;
  for (int i = 0; i < 4000; ++i) {  // out to beyond the arm's reach, and back
    const double way = i < 2000 ? 0.1e-3 * i : 0.1e-3 * (4000 - i);
    free.reference.p_WD = start + way * outward;
    free.reference.v_WD = (i < 2000 ? 0.1 : -0.1) * outward;
    const ImpedanceTorque& out = free.step();
    told |= out.status.near_singular;
    ASSERT_TRUE(out.tau.allFinite());
    ASSERT_FALSE(free.world.failure()) << *free.world.failure();
    ASSERT_LT(free.world.state().v.cwiseAbs().maxCoeff(), 6.0) << "at " << i << " ms";
  }
  EXPECT_TRUE(told);
}

TEST(ClosedLoop, BadInputGivesASafeTorqueAndAStatus) {
  ArmModel arm(kArm);
  FreeArm free(shaped_settings(arm));
  const JointVector good = free.step().terms.col(kGravity);
  const double nan = std::nan("");
  SurfaceEstimate surface;
  for (int what = 0; what < 4; ++what) {
    ArmTerms terms = free.terms;
    TipReference reference = free.reference;
    Wrench F = Wrench::Zero();
    if (what == 0) terms.v[3] = nan;
    if (what == 1) reference.p_WD.y() = nan;
    if (what == 2) F[2] = nan;
    if (what == 3) terms.g[0] = INFINITY;
    const ImpedanceTorque& out = free.controller.step(terms, reference, surface, F);
    EXPECT_TRUE(out.status.bad_input) << what;
    EXPECT_LT((out.tau - good).norm(), 1e-12) << what;
  }
  EXPECT_FALSE(free.step().status.bad_input) << "and it goes on when the input is good again";
}

TEST(ClosedLoop, RefusesSettingsThatCannotWork) {
  ArmModel arm(kArm);
  ImpedanceSettings s = shaped_settings(arm);
  s.wrench = WrenchFeedback::none;
  EXPECT_THROW(ImpedanceController(s, 7), InputError);
  s = shaped_settings(arm);
  s.null_space.q_0 = Eigen::VectorXd::Zero(6);
  EXPECT_THROW(ImpedanceController(s, 7), InputError);
  s = shaped_settings(arm);
  s.shaped_inertia.angular.normal = 1e-4;
  EXPECT_THROW(ImpedanceController(s, 7), InputError);
}

}  // namespace
}  // namespace impedraw
