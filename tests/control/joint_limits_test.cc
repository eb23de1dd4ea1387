// Repulsion from joint limits: monotonic, smooth, and without effect on the tip.
#include <algorithm>
#include <utility>

#include <gtest/gtest.h>

#include "dense_algebra.h"
#include "free_arm.h"

namespace impedraw {
namespace {

using namespace testing_arm;

// The null-space torque of joint j at distance d from its upper (or lower) limit: all else in the
// null space is zero.
JointVector repulsion(ArmModel& arm, int joint, double distance, bool upper, const ArmTerms& terms,
                      ControlStatus* status = nullptr) {
  ImpedanceSettings s = shaped_settings(arm);
  s.null_space.stiffness = Eigen::VectorXd::Zero(7);
  s.null_space.q_0 = terms.q;
  s.joint_range.lower = Eigen::VectorXd::Constant(7, -10.0);
  s.joint_range.upper = Eigen::VectorXd::Constant(7, 10.0);
  if (upper)
    s.joint_range.upper[joint] = terms.q[joint] + distance;
  else
    s.joint_range.lower[joint] = terms.q[joint] - distance;
  ImpedanceController controller(s, 7);
  TipReference reference;
  reference.p_WD = terms.X_WE.p;
  reference.n_WD = -terms.X_WE.R.col(2);
  const ImpedanceTorque& out = controller.step(terms, reference, {}, Wrench::Zero());
  if (status) *status = out.status;
  return out.terms.col(kNullSpace);
}

TEST(JointLimits, RepelAsTheFormulaSaysUpToTheLimitAndBeyond) {
  ArmModel arm(kArm);
  ArmTerms terms(7);
  arm.compute(working_posture(), JointVector::Zero(7), &terms);
  const ImpedanceSettings s;
  const Eigen::MatrixXd J = terms.J, M_inverse = inverse(terms.M);
  const Eigen::MatrixXd N = Eigen::MatrixXd::Identity(7, 7) -
                            J.transpose() * inverse(J * M_inverse * J.transpose()) * J * M_inverse;
  for (const int joint : {0, 2, 4}) {
    for (const bool upper : {false, true}) {
      double last = 0.0;
      for (double d = 1.2 * s.joint_range.margin; d > -s.joint_range.margin;
           d -= 0.01 * s.joint_range.margin) {
        ControlStatus status;
        const JointVector tau = repulsion(arm, joint, d, upper, terms, &status);
        const double into = std::max(0.0, (s.joint_range.margin - d) / s.joint_range.margin),
                     size = s.joint_range.torque * into * into;
        ASSERT_LT((tau - (upper ? -size : size) * N.col(joint)).norm(), 1e-9)
            << "joint " << joint + 1 << " at " << d << " rad";
        ASSERT_EQ(status.joint_limit, d < s.joint_range.margin);
        ASSERT_GE(tau.norm(), last - 1e-12) << "it must not weaken towards the limit, nor beyond";
        last = tau.norm();
        ASSERT_LT((J * M_inverse * tau).norm(), 1e-9) << "and the tip does not feel it";
      }
      EXPECT_GT(last, 0.1);
    }
  }
}

// Past a singular posture an arm that was held there swung back at 5 rad/s and more.
TEST(NullSpace, DoesNotPullAFastArmFaster) {
  ArmModel arm(kArm);
  ImpedanceSettings s = shaped_settings(arm);
  const JointVector q = working_posture();
  s.null_space.stiffness = Eigen::VectorXd::Constant(7, 10.0);
  s.null_space.q_0 = q + JointVector::Constant(7, 0.5);
  s.joint_range = {};
  ArmTerms terms(7);
  // What q_0 adds to the null-space torque, at a speed of all joints towards it.
  const auto pull = [&](double speed) {
    arm.compute(q, JointVector::Constant(7, speed), &terms);
    TipReference reference;
    reference.p_WD = terms.X_WE.p;
    reference.n_WD = -terms.X_WE.R.col(2);
    const auto torque = [&](const Eigen::VectorXd& q_0) {
      ImpedanceSettings with = s;
      with.null_space.q_0 = q_0;
      ImpedanceController controller(with, 7);
      return JointVector(
          controller.step(terms, reference, {}, Wrench::Zero()).terms.col(kNullSpace));
    };
    return (torque(s.null_space.q_0) - torque(q)).eval();
  };
  const JointVector at_rest = pull(0.0);
  EXPECT_GT(at_rest.norm(), 0.1);
  EXPECT_LT((pull(0.9) - at_rest).norm(), 1e-9);
  EXPECT_LT((pull(1.5) - 0.5 * at_rest).norm(), 1e-9);
  EXPECT_LT(pull(2.5).norm(), 1e-9);
  EXPECT_LT((pull(-2.5) - at_rest).norm(), 1e-9);  // braking is never weakened
}

TEST(JointLimits, RepelSmoothly) {
  ArmModel arm(kArm);
  ArmTerms terms(7);
  arm.compute(working_posture(), JointVector::Zero(7), &terms);
  const ImpedanceSettings s;
  const double h = 1e-3, unit = repulsion(arm, 2, 0.0, true, terms).norm() / s.joint_range.torque;
  for (double d = 1.2 * s.joint_range.margin; d > -0.5 * s.joint_range.margin; d -= 0.7e-3) {
    const JointVector bend =
        (repulsion(arm, 2, d + h, true, terms) - 2.0 * repulsion(arm, 2, d, true, terms) +
         repulsion(arm, 2, d - h, true, terms)) /
        (h * h);
    // No kink: the second difference remains that of the parabola. A kink of slope T/margin would
    // give T/(margin h), 75 times as much.
    ASSERT_LE(bend.norm() / unit,
              2.0 * s.joint_range.torque / (s.joint_range.margin * s.joint_range.margin) * 1.001)
        << "at " << d << " rad";
  }
}

TEST(JointLimits, KeepAJointOffThatItsRestPostureLiesBeyond) {
  ArmModel arm(kArm);
  for (const bool guarded : {false, true}) {
    ImpedanceSettings s = shaped_settings(arm);
    const double limit = working_posture()[2] + 0.25;
    s.null_space.q_0[2] = limit + 0.5;
    if (guarded) {
      s.joint_range.lower = Eigen::VectorXd::Constant(7, -2.9);
      s.joint_range.upper = Eigen::VectorXd::Constant(7, 2.9);
      s.joint_range.upper[2] = limit;
    }
    FreeArm free(s);
    double furthest = -10.0, away = 0.0;
    bool told = false;
    for (int i = 0; i < 4000; ++i) {
      told |= free.step().status.joint_limit;
      furthest = std::max(furthest, free.world.state().q[2]);
      away = std::max(away, (free.world.state().X_WE.p - free.reference.p_WD).norm());
    }
    EXPECT_EQ(told, guarded);
    EXPECT_LT(away, 1e-4) << "the pen stays where it is";
    if (guarded) {
      EXPECT_LT(furthest, limit);
      EXPECT_GT(furthest, limit - s.joint_range.margin) << "or it was never near";
    } else {
      EXPECT_GT(furthest, limit) << "or the limit was not needed";
    }
  }
}

// The turn about the pen's axis is the last joint's, and no null-space torque moves it.
TEST(JointLimits, TurnThePenAboutItsAxisAwayFromTheEndOfTheLastJointsRange) {
  ArmModel arm(kArm);
  for (const double side : {-1.0, 1.0}) {
    ImpedanceSettings s = shaped_settings(arm);
    s.joint_range.lower = Eigen::VectorXd::Constant(7, -2.9);
    s.joint_range.upper = Eigen::VectorXd::Constant(7, 2.9);
    const double limit = working_posture()[6] + side * 0.03;
    (side > 0.0 ? s.joint_range.upper : s.joint_range.lower)[6] = limit;
    FreeArm free(s);
    double away = 0.0, tilt = 0.0;
    for (int i = 0; i < 1500; ++i) {
      free.step();
      const Pose& X_WE = free.world.state().X_WE;
      away = std::max(away, (X_WE.p - free.reference.p_WD).norm());
      tilt = std::max(tilt, (X_WE.R.col(2) + free.reference.n_WD).norm());
    }
    const double room = side * (limit - free.world.state().q[6]);
    EXPECT_GT(room, 0.8 * s.joint_range.margin);
    EXPECT_LT(room, s.joint_range.margin);
    EXPECT_LT(away, 2e-5) << "the tip stays where it is";
    EXPECT_LT(tilt, 1e-3) << "and the pen leans as before";
  }
}

// Between its bounds the damping rises fivefold, and no further than a third of what the sampled
// loop bears.
TEST(SelfMotion, IsDampedMoreWhereItIsFast) {
  ArmModel arm(kArm);
  ArmTerms terms(7);
  arm.compute(working_posture(), JointVector::Zero(7), &terms);
  ImpedanceSettings s = shaped_settings(arm);
  s.null_space.q_0 = terms.q;
  const Eigen::MatrixXd J = terms.J, M = terms.M, M_inverse = inverse(M);
  const Eigen::MatrixXd N = Eigen::MatrixXd::Identity(7, 7) -
                            J.transpose() * inverse(J * M_inverse * J.transpose()) * J * M_inverse;
  // N is of rank one: what it leaves of any torque moves the arm within itself.
  Eigen::VectorXd self = M_inverse * N * Eigen::VectorXd::Unit(7, 2);
  self /= self.cwiseAbs().maxCoeff();
  ASSERT_LT((J * self).norm(), 1e-9);
  const Eigen::VectorXd D =
      2.0 * s.null_space.damping_ratio * (10.0 * M.diagonal().array()).sqrt().matrix();
  const double rate = self.dot(D.cwiseProduct(self)) / self.dot(M * self);
  for (const double delay : {1e-3, 3e-3}) {
    s.timing.loop_delay = delay;
    const double bearable = 0.5 / 3.0 / (s.timing.dt + delay) / rate;
    for (const auto& [speed, times] :
         {std::pair{0.3, 1.0}, std::pair{0.7, 1.0}, std::pair{1.05, 3.0}, std::pair{1.4, 5.0},
          std::pair{3.0, 5.0}}) {
      arm.compute(working_posture(), speed * self, &terms);
      ImpedanceController controller(s, 7);
      TipReference reference;
      reference.p_WD = terms.X_WE.p;
      reference.n_WD = -terms.X_WE.R.col(2);
      const JointVector tau =
          controller.step(terms, reference, {}, Wrench::Zero()).terms.col(kNullSpace);
      const Eigen::VectorXd expected =
          -std::clamp(bearable, 1.0, times) * speed * N * D.cwiseProduct(self);
      EXPECT_LT((tau - expected).norm(), 1e-9 * expected.norm() + 1e-9) << speed << " rad/s";
    }
  }
}

// On a rabbit on its side the pull to q_0 came and went from step to step by 20 Nm: it was faded
// where it sped a fast arm up, and was whole as soon as it no longer did.
TEST(SelfMotion, ThePullOfAFastArmDoesNotStepWhereItBeginsToSlowTheArmDown) {
  ArmModel arm(kArm);
  ImpedanceSettings s = shaped_settings(arm);
  const JointVector q = working_posture(), off = JointVector::LinSpaced(7, -0.5, 0.5);
  s.null_space.q_0 = q + off;
  s.null_space.stiffness = Eigen::VectorXd::Constant(7, 10.0);
  const JointVector pull = s.null_space.stiffness.cwiseProduct(off);
  JointVector across = JointVector::LinSpaced(7, 0.2, 1.0);
  across -= pull * pull.dot(across) / pull.squaredNorm();
  across *= 2.5 / across.cwiseAbs().maxCoeff();  // [rad/s]
  ArmTerms terms(7);
  JointVector last;
  for (double along = -1e-2; along <= 1e-2; along += 1e-4) {
    arm.compute(q, across + along * pull.normalized(), &terms);
    ImpedanceController controller(s, 7);
    TipReference reference;
    reference.p_WD = terms.X_WE.p;
    reference.n_WD = -terms.X_WE.R.col(2);
    const JointVector tau =
        controller.step(terms, reference, {}, Wrench::Zero()).terms.col(kNullSpace);
    if (last.size() > 0) {
      ASSERT_LT((tau - last).cwiseAbs().maxCoeff(), 0.02) << along;
    }
    last = tau;
  }
}

}  // namespace
}  // namespace impedraw
