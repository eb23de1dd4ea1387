// How much of a plan's angular acceleration torques of a limited rate follow.
#include "impedraw/control/plan_turn.h"

#include <gtest/gtest.h>

#include "any_arm.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

TEST(PlanTurn, IsFollowedAsFarAsTheTorquesRatesAllow) {
  testing_arm::AnyArm any(6);
  for (int i = 0; i < 20; ++i) {
    const ArmTerms arm = any.terms();
    OperationalSpace space;
    space.update(arm);
    LimitSettings limits;
    limits.torque_rate = Eigen::VectorXd::Constant(7, any.number(500.0, 1500.0));
    const auto followed = [&](const Vector3d& alpha) {
      TipReference reference;
      reference.alpha_WD = alpha;
      return with_followed_turn(arm, space, limits, reference).alpha_WD;
    };
    const auto share = [&](const Vector3d& alpha) {
      const JointVector tau = arm.J.transpose() * (space.inertia().rightCols<3>() * alpha);
      return (tau.cwiseAbs().cwiseQuotient(limits.torque_rate) / kTurnTime).maxCoeff();
    };
    const Vector3d calm = any.vector(0.1), edge = 1e4 * any.direction();
    ASSERT_LT(share(calm), 1.0);
    EXPECT_EQ(followed(calm), calm);
    const Vector3d slower = followed(edge);
    EXPECT_NEAR(share(slower), 1.0, 1e-9);
    EXPECT_NEAR(slower.normalized().dot(edge.normalized()), 1.0, 1e-12);
    limits.torque_rate.resize(0);
    EXPECT_EQ(followed(edge), edge);
  }
}

}  // namespace
}  // namespace impedraw
