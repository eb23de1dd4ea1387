// The controller works on any arm: random serial arms with 6 and 7 joints, against MuJoCo and the
// desired motion.
#include <cmath>

#include <gtest/gtest.h>

#include "dense_algebra.h"
#include "free_arm.h"
#include "random_arm.h"

namespace impedraw {
namespace {

using namespace testing_arm;

JointVector random_joints(int n, double range, std::mt19937& rng) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  JointVector x(n);
  for (int i = 0; i < n; ++i) x[i] = range * unit(rng);
  return x;
}

TEST(RandomArms, TermsAgreeWithMujoco) {
  for (const int n : {6, 7}) {
    for (unsigned seed = 1; seed <= 8; ++seed) {
      SCOPED_TRACE(testing::Message() << n << " joints, seed " << seed);
      const RandomArm file(n, seed);
      ArmModel arm(file.path());
      ASSERT_EQ(arm.joints(), n);
      World world(file.path(), nullptr, {});
      ArmTerms terms(n), before(n), after(n);
      std::mt19937 rng(seed);
      for (int i = 0; i < 20; ++i) {
        const JointVector q = random_joints(n, 2.8, rng), v = random_joints(n, 2.0, rng);
        arm.compute(q, v, &terms);
        world.set_state(q, v);
        const World::Terms other = world.terms();
        EXPECT_LT((terms.M - other.M).norm(), 1e-8 * other.M.norm());
        EXPECT_LT((terms.Cv + terms.g - other.bias).norm(), 1e-8 * (1.0 + other.bias.norm()));
        EXPECT_LT((terms.J - other.J).norm(), 1e-8 * other.J.norm());
        EXPECT_LT((terms.X_WE.p - world.state().X_WE.p).norm(), 1e-8);
        EXPECT_LT((terms.X_WE.R - world.state().X_WE.R).norm(), 1e-8);
        const double h = 1e-6;
        arm.compute(q - h * v, v, &before);
        arm.compute(q + h * v, v, &after);
        const Vector6 drift = (after.J - before.J) / (2.0 * h) * v;
        EXPECT_LT((terms.Jdot_v - drift).norm(), 1e-6 * (1.0 + drift.norm()));
        world.set_state(q, JointVector::Zero(n));  // at rest all of the bias is gravity
        EXPECT_LT((terms.g - world.terms().bias).norm(), 1e-8 * (1.0 + terms.g.norm()));
      }
    }
  }
}

// A posture far from singular: the tip's effective masses are below 30 kg, with a lever of
// 0.3 m.
JointVector easy_posture(ArmModel& arm, std::mt19937& rng) {
  OperationalSpaceSettings easy;
  easy.max_effective_mass = 30.0;
  OperationalSpace space(easy);
  const int n = arm.joints();
  ArmTerms terms(n);
  for (int i = 0; i < 20000; ++i) {
    arm.compute(random_joints(n, 2.2, rng), JointVector::Zero(n), &terms);
    if (space.update(terms)) return terms.q;
  }
  throw std::logic_error("no easy posture");
}

ImpedanceSettings settings_of(const ArmModel& arm, const JointVector& q) {
  ImpedanceSettings s;
  s.null_space.q_0 = q;
  s.limits.torque = arm.limits().torque;
  s.stiffness = {{300.0, 200.0}, {5.0, 0.0}};
  s.reference_stiffness = {{300.0, 200.0}, {5.0, 2.0}};
  s.stability_check.contact_stiffness_max = 1e3;
  return s;
}

// M_d ẍ + B ẋ + K (x − x_D) = 0 from rest, integrated finely. The arm follows it within 2 % of the
// step over the whole motion.
void follow(const RandomArm& file, const ImpedanceSettings& s, const JointVector& q) {
  const int n = static_cast<int>(q.size());
  FreeArm free(s, q, FreeArm::at_step(s.timing.dt), nullptr, file.path());
  const World::Terms t = free.world.terms();
  const Eigen::Vector3d n_W = free.reference.n_WD, start = free.reference.p_WD;
  Matrix6 M_d = Matrix6::Zero(), K = Matrix6::Zero(), K_damping = Matrix6::Zero();
  if (s.inertia == InertiaShaping::shaped) {
    M_d.topLeftCorner<3, 3>() = s.shaped_inertia.linear.matrix(n_W);
    M_d.bottomRightCorner<3, 3>() = s.shaped_inertia.angular.matrix(n_W);
  } else {
    M_d = (s.inertia == InertiaShaping::scaled ? s.inertia_scale : 1.0) *
          operational_inertia(t.J, t.M);
    M_d = 0.5 * (M_d + M_d.transpose()).eval();
  }
  K.topLeftCorner<3, 3>() = s.stiffness.linear.matrix(n_W);
  K.bottomRightCorner<3, 3>() = s.stiffness.angular.matrix(n_W);
  K_damping = K;
  K_damping.bottomRightCorner<3, 3>() = s.reference_stiffness.angular.matrix(n_W);
  const Modes damped = modes(K_damping, M_d);
  const Matrix6 Q = damped.Q;
  const Matrix6 B = M_d * Q *
                    (2.0 * s.damping_ratio * damped.omega_squared.cwiseSqrt()).asDiagonal() *
                    Q.transpose() * M_d;

  Vector6 x = Vector6::Zero(), x_dot = Vector6::Zero(), x_D = Vector6::Zero();
  x_D.head<3>() = Eigen::Vector3d(1e-3, -0.5e-3, 0.8e-3);
  free.reference.p_WD += x_D.head<3>();
  const Matrix6 A = inverse(M_d);
  for (int i = 0; i < 800; ++i) {
    ASSERT_LT((free.world.state().X_WE.p - start - x.head<3>()).norm(), 0.02 * x_D.norm())
        << "at " << i << " ms, " << n << " joints";
    ASSERT_TRUE(free.step().status.ok());
    for (int k = 0; k < 50; ++k) {
      x_dot += s.timing.dt / 50.0 * A * (K * (x_D - x) - B * x_dot);
      x += s.timing.dt / 50.0 * x_dot;
    }
  }
  EXPECT_GT(x.head<3>().norm(), 0.5 * x_D.norm()) << "or it had not moved by then";
}

TEST(RandomArms, MoveAsTheWantedMassOnASpring) {
  for (const int n : {6, 7}) {
    for (unsigned seed = 1; seed <= 6; ++seed) {
      const RandomArm file(n, seed);
      ArmModel arm(file.path());
      std::mt19937 rng(seed);
      const JointVector q = easy_posture(arm, rng);
      for (const double scale : {0.0, 1.0, 1.5}) {  // 0: shaped
        SCOPED_TRACE(testing::Message() << n << " joints, seed " << seed << ", scale " << scale);
        ImpedanceSettings s = settings_of(arm, q);
        if (scale > 0.0) {
          s.inertia = InertiaShaping::scaled;
          s.inertia_scale = scale;
        }
        follow(file, s, q);
      }
    }
  }
}

}  // namespace
}  // namespace impedraw
