// Postures near the ends of the joints' ranges, against the motion that the law asks for, in steps
// of 1 ms.
#include "impedraw/planning/preflight/posture_check.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "arm_on_surface.h"
#include "impedraw/arm/least_energy_step.h"
#include "impedraw/control/heading.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr double kLean = 15.0 * std::numbers::pi / 180.0, kRound = 0.06 * std::numbers::pi;

// Round after round about a hill.
PenPlacement on_hill(double way) {
  const double angle = 2.0 * std::numbers::pi * way / kRound;
  const Vector3d out(std::cos(angle), std::sin(angle), 0.0);
  return {Vector3d(0.6, 0.0, 0.1) + kRound / (2.0 * std::numbers::pi) * out,
          -std::sin(kLean) * out - std::cos(kLean) * Vector3d::UnitZ()};
}

// Each round turns the last joint by 2π (1 − cos 15°) = 12°, towards one of its ends: there the law
// turns the pen back about its own axis.
TEST(PostureCheck, TurnsThePenAwayFromTheEndOfAJointsRangeAsTheLawDoes) {
  constexpr double kStep = 4e-3;  // [m]
  ArmModel arm(surfaces::kArm);
  PreflightSettings settings;
  settings.speed = 0.1;
  settings.rest_q = find_posture(arm, on_hill(0.0), surfaces::start_posture(arm)).q;
  PostureCheck check(arm, nullptr, *settings.rest_q, settings);
  ImpedanceSettings law;
  law.joint_range.lower = arm.limits().lower;
  law.joint_range.upper = arm.limits().upper;
  const JointRange range(law);
  OperationalSpace space;
  ArmTerms terms(arm.joints());
  double least = 1.0;
  for (const double end : {arm.limits().lower[6], arm.limits().upper[6]}) {
    JointVector q = *settings.rest_q;
    q[6] = 0.9 * end;
    Posture posture = check.begin(on_hill(0.0), q);
    q = posture.q;
    for (double way = kStep; way < 6.0 * kRound; way += kStep) {
      posture = check.follow(on_hill(way), posture, kStep);
      ASSERT_FALSE(posture.problem) << posture.text << ", " << way;
      constexpr int kPieces = 40;
      for (int k = 1; k <= kPieces; ++k) {
        arm.compute(q, JointVector::Zero(q.size()), &terms);
        space.update(terms);
        const PenPlacement pen = on_hill(way - kStep + k * kStep / kPieces);
        Vector6 move = tip_displacement(terms.X_WE, pen.p_WE, pen.z_WE);
        move.tail<3>() += heading_rate(terms, space, range) * kStep / kPieces / settings.speed *
                          terms.X_WE.R.col(2);
        // In the null space equal stiffnesses of 10 Nm/rad pull, and the ends of ranges push.
        Eigen::VectorXd pull = *settings.rest_q - q;
        for (int j = 0; j < arm.joints(); ++j) {
          const JointRange::Depth depth = range.depth(q, j);
          pull[j] += law.joint_range.torque / 10.0 *
                     (depth.lower * depth.lower - depth.upper * depth.upper);
        }
        const Eigen::MatrixXd J = terms.J;
        const Eigen::VectorXd z = J.fullPivLu().kernel().col(0).normalized();
        q += J.transpose() * (J * J.transpose()).inverse() * move +
             kStep / kPieces / 0.05 * z.dot(pull) * z;
      }
      least = std::min(least, arm.limits().upper[6] - std::abs(q[6]));
      EXPECT_NEAR(posture.q[6], q[6], 0.03) << way;
    }
  }
  EXPECT_LT(least, 0.12);  // it came there
  EXPECT_GT(least, settings.joint_margin);
}

}  // namespace
}  // namespace impedraw
