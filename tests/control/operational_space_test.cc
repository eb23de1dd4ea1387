// Identities of the operational space, damping against a generalised eigensolver, and behaviour
// near a singular posture.
#include "impedraw/control/operational_space.h"

#include <gtest/gtest.h>

#include "arm_fixture.h"
#include "dense_algebra.h"
#include "impedraw/control/damping.h"

namespace impedraw {
namespace {

using namespace testing_arm;

TEST(OperationalSpace, IdentitiesHoldOverRandomStates) {
  ArmModel arm(kArm);
  const unsigned seed = 1;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  OperationalSpace space;
  for (int i = 0; i < 200; ++i) {
    const ArmTerms t = random_terms(arm, rng);
    ASSERT_TRUE(space.update(t));
    // The textbook formula, with full inverses.
    const Eigen::MatrixXd M_inverse = inverse(t.M);
    const Matrix6 lambda_inverse = t.J * M_inverse * t.J.transpose();
    EXPECT_LT((space.inverse_inertia() - lambda_inverse).norm(), 1e-9 * lambda_inverse.norm());
    const Matrix6 lambda = space.inertia();
    EXPECT_LT((lambda * lambda_inverse - Matrix6::Identity()).norm(), 1e-8);
    EXPECT_LT((lambda - lambda.transpose()).norm(), 1e-9 * lambda.norm());
    EXPECT_GT(modes(lambda, Matrix6::Identity()).omega_squared.minCoeff(), 0.0);
    for (int k = 0; k < 6; ++k) {  // J̄ᵀ Jᵀ = I
      const Vector6 unit = Vector6::Unit(k);
      EXPECT_LT((space.project_to_tip(t.J.transpose() * unit) - unit).norm(), 1e-9);
      // J̄
      const Eigen::VectorXd speed = M_inverse * t.J.transpose() * lambda * unit;
      EXPECT_LT((space.joint_speed(unit) - speed).norm(), 1e-9 * speed.norm());
      TwoVelocities two;
      two << Vector6::Zero(), 2.0 * unit;
      EXPECT_EQ(space.joint_speeds(two).col(0).norm(), 0.0);
      EXPECT_LT((space.joint_speeds(two).col(1) - 2.0 * speed).norm(), 1e-9 * speed.norm());
    }
    const JointVector tau = 10.0 * JointVector::Random(7);
    const JointVector tau_null = tau - t.J.transpose() * space.project_to_tip(tau);
    EXPECT_LT((t.J * M_inverse * tau_null).norm(), 1e-9 * (t.J * M_inverse * tau).norm());
  }
}

TEST(OperationalSpace, ReleasesALostDirectionAndSaysSo) {
  ArmModel arm(kArm);
  OperationalSpace space;
  ArmTerms t(7);
  double largest = 0.0;
  int released = 0;
  for (double bend = -0.05; bend <= 0.05; bend += 1e-4) {  // through the stretched elbow
    JointVector q = JointVector::Zero(7);
    q << 0.2, 0.5, 0.0, bend, 0.0, 0.4, 0.0;
    arm.compute(q, JointVector::Zero(7), &t);
    released += !space.update(t);
    const Vector6 force = space.inertia() * Vector6(Vector6::Ones());
    ASSERT_TRUE(force.allFinite());
    largest = std::max(largest, (t.J.transpose() * force).norm());
  }
  EXPECT_GT(released, 10);
  EXPECT_LT(largest, 400.0);  // 1 m/s² along every axis, at most max_effective_mass of it
  EXPECT_LT(released, 1001);
}

TEST(OperationalSpace, ReleasesATurnThatTheArmHasLost) {
  ArmModel arm(kArm);
  ArmTerms t(7);
  arm.compute(working_posture(), JointVector::Zero(7), &t);
  OperationalSpace space;
  EXPECT_TRUE(space.update(t));
  t.J.row(4) *= 1e-4;
  EXPECT_FALSE(space.update(t));
}

// B column by column.
Matrix6 matrix_of(ModalDamping& modal, const Matrix6& U, const Matrix6& U_inverse, const Matrix6& K,
                  double damping_ratio) {
  modal.design(U, K.topLeftCorner<3, 3>(), K.bottomRightCorner<3, 3>(), damping_ratio);
  Matrix6 B;
  for (int i = 0; i < 6; ++i) B.col(i) = modal.apply(U_inverse, Vector6::Unit(i));
  return B;
}

TEST(ModalDamping, AgreesWithTheGeneralisedEigenproblem) {
  ArmModel arm(kArm);
  std::mt19937 rng(5);
  OperationalSpace space;
  ModalDamping modal;
  Matrix6 K = Matrix6::Zero();
  K.diagonal() << 3000, 3000, 1500, 100, 100, 10;
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(space.update(random_terms(arm, rng)));
    const Matrix6 M_d = space.inertia();
    const Modes textbook = modes(K, 0.5 * (M_d + M_d.transpose()));
    const Matrix6 Q = textbook.Q;
    const Matrix6 expected = M_d * Q *
                             (2.0 * 0.7 * textbook.omega_squared.cwiseSqrt()).asDiagonal() *
                             Q.transpose() * M_d;
    const Matrix6 B =
        matrix_of(modal, space.inverse_inertia_factor(), space.inertia_factor(), K, 0.7);
    EXPECT_LT((B - expected).norm(), 1e-4 * expected.norm());
    EXPECT_NEAR(modal.largest_rate(), 1.4 * std::sqrt(textbook.omega_squared.maxCoeff()),
                1e-4 * modal.largest_rate());
  }
}

// From step to step the modes are refined, not found anew.
TEST(ModalDamping, OfAnArmThatMovesIsThatOfEachPosture) {
  ArmModel arm(kArm);
  OperationalSpace space;
  Matrix6 K = Matrix6::Zero();
  K.diagonal() << 3000, 3000, 1500, 100, 100, 10;
  for (const double speed : {0.05, 0.3, 3.0}) {  // of each joint [rad/s]
    ModalDamping modal;
    ArmTerms terms(arm.joints());
    double worst = 0.0;
    for (int i = 0; i < 3000; ++i) {
      JointVector q = working_posture();
      for (int j = 0; j < q.size(); ++j) q[j] += 0.3 * std::sin(speed / 0.3 * 1e-3 * i + j);
      arm.compute(q, JointVector::Zero(q.size()), &terms);
      ASSERT_TRUE(space.update(terms));
      ModalDamping anew;
      const Matrix6 &U = space.inverse_inertia_factor(), &U_inverse = space.inertia_factor();
      const Matrix6 B = matrix_of(modal, U, U_inverse, K, 0.7),
                    expected = matrix_of(anew, U, U_inverse, K, 0.7);
      // in the modes' own scale: A^½ B A^½
      const Matrix6 off = U.transpose() * (B - expected) * U, all = U.transpose() * expected * U;
      worst = std::max(worst, off.norm() / all.norm());
    }
    EXPECT_LT(worst, 5e-4) << "at " << speed << " rad/s";
  }
}

TEST(ModalDamping, OfADiagonalInertiaIsTheAxesOwn) {
  const TipGain K{{3000.0, 1500.0}, {100.0, 10.0}}, M{{4.0, 3.0}, {0.05, 0.02}};
  const TipGain b = diagonal_damping(K, M, 0.8);
  Matrix6 K6 = Matrix6::Zero(), U = Matrix6::Zero();
  K6.diagonal() << 3000, 3000, 1500, 100, 100, 10;
  Vector6 m;
  m << 4, 4, 3, 0.05, 0.05, 0.02;
  U.diagonal() = m.cwiseInverse().cwiseSqrt();
  ModalDamping modal;
  Vector6 expected;
  expected << b.linear.tangent, b.linear.tangent, b.linear.normal, b.angular.tangent,
      b.angular.tangent, b.angular.normal;
  EXPECT_LT((matrix_of(modal, U, U.diagonal().cwiseInverse().asDiagonal(), K6, 0.8) -
             Matrix6(expected.asDiagonal()))
                .norm(),
            1e-9);
}

TEST(AxialGain, IsTheTurnedDiagonal) {
  std::mt19937 rng(9);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d n = Eigen::Vector3d(normal(rng), normal(rng), normal(rng)).normalized(),
                          x(normal(rng), normal(rng), normal(rng));
    Eigen::Matrix3d R;
    R.col(2) = n;
    R.col(0) = n.unitOrthogonal();
    R.col(1) = n.cross(R.col(0));
    const AxialGain g{7.0, 3.0};
    const Eigen::Matrix3d expected = R * Eigen::Vector3d(7, 7, 3).asDiagonal() * R.transpose();
    EXPECT_LT((g.matrix(n) - expected).norm(), 1e-12);
    EXPECT_LT((g.apply(n, x) - expected * x).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace impedraw
