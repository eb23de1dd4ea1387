// Torques and limits of the joints, each against its closed form: ends of ranges and speeds, the
// null space, the damper, the brake, and what of a disturbance is compensated.
#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "any_arm.h"
#include "dense_algebra.h"
#include "impedraw/control/disturbance.h"
#include "impedraw/control/heading.h"
#include "impedraw/control/joint_brake.h"
#include "impedraw/control/joint_damper.h"
#include "impedraw/control/null_space.h"
#include "impedraw/control/speed_limit.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
using testing_arm::AnyArm;

ImpedanceSettings with_ranges(double end, double speed) {
  ImpedanceSettings s;
  s.joint_range.lower = Eigen::VectorXd::Constant(7, -end);
  s.joint_range.upper = Eigen::VectorXd::Constant(7, end);
  s.limits.joint_speed = Eigen::VectorXd::Constant(7, speed);
  return s.completed(7);
}

// An arm, and its operational space.
struct Posture {
  ArmTerms arm;
  OperationalSpace space;
  explicit Posture(const ArmTerms& terms) : arm(terms) { space.update(arm); }

  Eigen::MatrixXd M_inverse() const { return testing_arm::inverse(arm.M); }
  Eigen::MatrixXd J_bar() const {  // (16)
    return M_inverse() * arm.J.transpose() * testing_arm::operational_inertia(arm.J, arm.M);
  }
};

TEST(JointRange, AJointAtItsHighestSpeedComesToRestShortOfTheEnd) {
  const JointRange range(with_ranges(1.0, 2.0));
  for (const double way : {-1.0, 1.0}) {
    JointVector q = JointVector::Zero(7);
    EXPECT_EQ(range.most_speed(q, 3, way), 2.0);
    double last = 2.0;
    for (int i = 0; i < 3000; ++i) {
      const double v = range.most_speed(q, 3, way);
      ASSERT_LE(v, last + 1e-12);
      last = v;
      q[3] += 1e-3 * way * v;
    }
    EXPECT_LT(std::abs(q[3]), 1.0);
    EXPECT_GT(std::abs(q[3]), 1.0 - JointRange::kShortOfEnd - 1e-3);
    EXPECT_LE(last, JointRange::kCreep + 1e-9);
    EXPECT_EQ(range.most_speed(q, 3, -way), 2.0) << "away from the end it is as fast as ever";
    q[3] = 1.1 * way;
    EXPECT_EQ(range.most_speed(q, 3, way), 0.0);
  }
  JointVector q = JointVector::Zero(7);
  for (const double q_2 : {-0.7, 0.0, 0.6}) {
    q[2] = q_2;
    EXPECT_NEAR(range.room(q), 1.0 - std::abs(q_2), 1e-12);
  }
  EXPECT_EQ(JointRange(ImpedanceSettings{}).room(JointVector::Zero(7)),
            std::numeric_limits<double>::infinity());
}

TEST(Heading, TurnsThePenSoThatJointsLeaveTheirMargins) {
  const ImpedanceSettings s = with_ranges(1.0, 2.0);
  const JointRange range(s);
  AnyArm any(1);
  for (int i = 0; i < 50; ++i) {
    ArmTerms arm = any.terms();
    arm.q.setZero();
    const Posture still(arm);
    EXPECT_EQ(heading_rate(still.arm, still.space, range), 0.0);
    const int j = i % 7;
    const double side = i % 2 ? 1.0 : -1.0;
    arm.q[j] = side * (1.0 - 0.5 * s.joint_range.margin);
    const Posture at(arm);
    Vector6 spin = Vector6::Zero();
    spin.tail<3>() = arm.X_WE.R.col(2);
    const double rate = heading_rate(at.arm, at.space, range);
    const Eigen::VectorXd v = at.J_bar() * spin * rate;
    EXPECT_LT(side * v[j], 0.0);
    EXPECT_LE(std::abs(rate), kHeadingRate);
  }
}

TEST(Heading, YawIsTheTurnAboutTheNormalOfWhatMayLean) {
  AnyArm any(8);
  for (int i = 0; i < 50; ++i) {
    const Vector3d n = any.direction(), a = n.unitOrthogonal();
    const double yaw = any.number(-3.1, 3.1);
    const Vector3d b = Eigen::AngleAxisd(yaw, n) * a;
    EXPECT_NEAR(yaw_between(a + any.number(-2, 2) * n, b + any.number(-2, 2) * n, n), yaw, 1e-12);
  }
}

TEST(Heading, ALedPenTurnsAboutItsNormalAsItsPlanDoes) {
  const Vector3d n = Vector3d(0.3, -0.2, 0.9).normalized();
  Pose X_WE;
  X_WE.R.col(0) = n.unitOrthogonal();
  TipReference plan;
  plan.x_WD = Eigen::AngleAxisd(0.4, n) * X_WE.R.col(0);
  plan.yaw_rate = 1.2;
  plan.yaw_acceleration = -0.7;
  TipTarget d;
  d.axis_WD = n;
  d.V = d.Vdot = d.Ke = Vector6::Ones();
  lead_heading(plan, X_WE, 3.0, &d);
  Vector6 about = Vector6::Zero();
  about.tail<3>() = n;
  EXPECT_LT((d.V - Vector6::Ones() - 1.2 * about).norm(), 1e-12);
  EXPECT_LT((d.Vdot - Vector6::Ones() + 0.7 * about).norm(), 1e-12);
  EXPECT_LT((d.Ke - Vector6::Ones() - 3.0 * 0.4 * about).norm(), 1e-12);
}

TEST(SpeedLimit, KeepsTheTipAndEveryJointWithinTheirLimits) {
  ImpedanceSettings s = with_ranges(3.0, 0.8);
  s.limits.tip_speed = 0.5;
  s.limits.turn_speed = 1.0;
  const SpeedLimit limit(s);
  const JointRange range(s);
  TipImpedance impedance(s);
  AnyArm any(2);
  int changed = 0;
  for (int i = 0; i < 300; ++i) {
    const Posture at(any.terms(0.3));
    const Vector3d n = any.direction();
    impedance.update(at.space, n);
    TipTarget d;
    d.V = any.wrench(i % 3 ? 1.0 : 0.05);
    d.Vdot = any.wrench(1.0);
    d.Ke = any.wrench(i % 2 ? 60.0 : 0.05);
    const TipTarget before = d;
    const bool limited = limit.apply(at.arm, at.space, impedance, range, &d);
    changed += limited;
    const Vector6 V_end = d.V + impedance.follow(d.Ke);
    EXPECT_LE(V_end.head<3>().norm(), 0.5 + 1e-12);
    EXPECT_LE(V_end.tail<3>().norm(), 1.0 + 1e-12);
    const Eigen::VectorXd v_end = at.arm.v + at.J_bar() * (V_end - at.arm.V_WE);
    EXPECT_LE(v_end.cwiseAbs().maxCoeff(), 0.8 + 1e-9) << "the arm keeps its motion within itself";
    if (!limited) {
      EXPECT_EQ(d.V, before.V);
      EXPECT_EQ(d.Vdot, before.Vdot);
      EXPECT_EQ(d.Ke, before.Ke);
      continue;
    }
    EXPECT_EQ(d.Ke.norm(), 0.0);
    const Vector6 asked = before.V + impedance.follow(before.Ke);
    EXPECT_NEAR(d.V.head<3>().normalized().dot(asked.head<3>().normalized()), 1.0, 1e-9);
    if (d.V.head<3>().norm() < 0.9 * asked.head<3>().norm()) {
      EXPECT_LE(d.Vdot.head<3>().dot(d.V.head<3>()), 1e-9) << "it is not accelerated further";
    }
    if (d.V.tail<3>().norm() < 0.9 * asked.tail<3>().norm()) {
      EXPECT_LE(d.Vdot.tail<3>().dot(d.V.tail<3>()), 1e-9) << "nor turned faster";
    }
  }
  EXPECT_GT(changed, 50);
  EXPECT_LT(changed, 280);
}

TEST(SpeedLimit, OneFastPartOfATargetThatElseStandsIsLimited) {
  for (const bool joints : {false, true}) {
    ImpedanceSettings s = joints ? with_ranges(3.0, 10.0) : ImpedanceSettings();
    s.limits.tip_speed = 0.2;
    s.limits.turn_speed = 0.3;
    const SpeedLimit limit(s);
    TipImpedance impedance(s);
    AnyArm any(9);
    const Posture at(any.terms(0.0));
    impedance.update(at.space, Vector3d::UnitZ());
    for (int part = 0; part < 4; ++part) {
      TipTarget d;
      d.V = d.Vdot = d.Ke = Vector6::Zero();
      const Vector3d way = 0.4 * any.direction();
      if (part < 2) d.V.segment<3>(3 * part) = way;
      if (part == 2) d.Ke.head<3>() = s.stiffness.linear.tangent * way;
      if (part == 3) d.Ke.tail<3>() = s.stiffness.angular.tangent * way;
      EXPECT_TRUE(limit.apply(at.arm, at.space, impedance, JointRange(s), &d)) << part;
    }
  }
}

TEST(SpeedLimit, TheFastestJointGetsAsMuchAsItMayAlsoSlowlyAtItsEnd) {
  for (const bool at_end : {false, true}) {
    ImpedanceSettings s = with_ranges(3.0, at_end ? 10.0 : 0.4);
    s.limits.tip_speed = s.limits.turn_speed = 10.0;
    const SpeedLimit limit(s);
    const JointRange range(s);
    TipImpedance impedance(s);
    AnyArm any(10);
    for (int i = 0; i < 30; ++i) {
      ArmTerms arm = any.terms(0.0);
      if (at_end) arm.q[i % 7] = 2.99;
      const Posture at(arm);
      impedance.update(at.space, Vector3d::UnitZ());
      TipTarget d;
      d.V = d.Vdot = d.Ke = Vector6::Zero();
      d.V.head<3>() = (at_end ? 0.05 : 1.0) * any.direction();
      const Eigen::VectorXd asked = at.J_bar() * d.V;
      Eigen::VectorXd most(7);
      for (int j = 0; j < 7; ++j) most[j] = range.most_speed(arm.q, j, asked[j]);
      const double share = std::min(1.0, (most.array() / asked.array().abs()).minCoeff());
      const Vector6 expected = share * d.V;
      limit.apply(arm, at.space, impedance, range, &d);
      EXPECT_LT((d.V - expected).norm(), 1e-9);
    }
  }
}

TEST(NullSpace, PullsCalmsAndKeepsOffTheEndsWithoutMovingTheTip) {
  ImpedanceSettings s = with_ranges(1.0, 5.0);
  s.null_space.q_0 = Eigen::VectorXd::Constant(7, 0.3);
  NullSpace null_space(s);
  const JointRange range(s);
  AnyArm any(3);
  for (int i = 0; i < 50; ++i) {
    ArmTerms arm = any.terms(0.0);
    arm.q *= 0.8;  // outside of the margins
    const Eigen::VectorXd pull = s.null_space.stiffness.cwiseProduct(s.null_space.q_0 - arm.q);
    {
      const Posture at(arm);
      EXPECT_LT((null_space.unprojected(at.arm, at.space, range) - pull).norm(), 1e-12);
      EXPECT_FALSE(null_space.near_range_end());
      const Eigen::VectorXd tau = null_space.torque(at.arm, at.space, range);
      EXPECT_LT((arm.J * at.M_inverse() * tau).norm(), 1e-9);
      EXPECT_LT((tau - pull + arm.J.transpose() * at.J_bar().transpose() * pull).norm(), 1e-9);
    }
    // Along the pull, fast enough that it has faded; the damping is bounded by what the loop bears.
    arm.v = pull / pull.cwiseAbs().maxCoeff() * 2.0 * NullSpace::kSelfMotionSpeed;
    arm.V_WE = arm.J * arm.v;
    const Eigen::VectorXd D = 2.0 * s.null_space.damping_ratio *
                              s.null_space.stiffness.cwiseProduct(arm.M.diagonal()).cwiseSqrt();
    {
      const Posture at(arm);
      const Eigen::VectorXd self = arm.v - at.J_bar() * arm.V_WE;
      const double rate = self.dot(D.cwiseProduct(self)) / self.dot(arm.M * self);
      const double times = std::clamp(bearable_rate(s.timing.damping_delay()) / rate, 1.0,
                                      1.0 + NullSpace::kMoreDamping);
      EXPECT_LT((null_space.unprojected(at.arm, at.space, range) +
                 times * D.cwiseProduct(Eigen::VectorXd(arm.v)))
                    .norm(),
                1e-6 * times * D.norm());
    }
    // At rest in the margin of one end.
    arm.v.setZero();
    arm.V_WE.setZero();
    const double depth = any.number(0.1, 1.0), side = i % 2 ? 1.0 : -1.0;
    arm.q[2] = side * (1.0 - (1.0 - depth) * s.joint_range.margin);
    const Posture at(arm);
    const double extra = null_space.unprojected(at.arm, at.space, range)[2] -
                         s.null_space.stiffness[2] * (0.3 - arm.q[2]);
    EXPECT_NEAR(extra, -side * s.joint_range.torque * depth * depth, 1e-9);
    EXPECT_TRUE(null_space.near_range_end());
  }
}

// All inertias of an arm down to the hundred-thousandth of the usual ones.
TEST(NullSpace, ALightArmIsPulledAndDampedAsTheSampledLoopBears) {
  ImpedanceSettings s = with_ranges(3.0, 0.6);
  s.null_space.q_0 = Eigen::VectorXd::Constant(7, 0.4);
  NullSpace null_space(s);
  const JointRange range(s);
  const double most = 1.0 / s.timing.damping_delay();
  int weaker = 0, softer = 0;
  AnyArm any(5);
  for (int i = 0; i < 100; ++i) {
    ArmTerms arm = any.terms(0.0);
    arm.M *= std::pow(10.0, -any.number(0.0, 5.0));
    const Posture at(arm);
    const Eigen::VectorXd D = 2.0 * s.null_space.damping_ratio *
                              s.null_space.stiffness.cwiseProduct(arm.M.diagonal()).cwiseSqrt();
    const Eigen::VectorXd pull = s.null_space.stiffness.cwiseProduct(s.null_space.q_0 - arm.q);
    const auto self_motion = [&](const Eigen::VectorXd& tau) -> Eigen::VectorXd {
      return at.M_inverse() * (tau - arm.J.transpose() * at.J_bar().transpose() * tau);
    };
    const Eigen::VectorXd z = self_motion(pull);
    const double rate = z.dot(D.cwiseProduct(z)) / z.dot(arm.M * z);
    const Eigen::VectorXd pulled = null_space.unprojected(at.arm, at.space, range);
    const double share = pulled.dot(pull) / pull.squaredNorm();
    EXPECT_LT((pulled - share * pull).norm(), 1e-9);
    EXPECT_LE((self_motion(pulled) / most).cwiseAbs().maxCoeff(), 0.6 * (1.0 + 1e-6));
    weaker += share < 0.99;
    EXPECT_TRUE(share < 0.99 || std::abs(share - 1.0) < 1e-12 ||
                (self_motion(pulled) / most).cwiseAbs().maxCoeff() > 0.59);
    // Slow enough that nothing fades or calms.
    arm.v = z / z.cwiseAbs().maxCoeff() * 0.1;
    arm.V_WE.setZero();
    const Posture moving(arm);
    const Eigen::VectorXd damped = pulled - null_space.unprojected(moving.arm, moving.space, range);
    const double times = damped.norm() / D.cwiseProduct(Eigen::VectorXd(arm.v)).norm();
    EXPECT_NEAR(times, std::min(1.0, most / rate), 1e-6);
    softer += times < 0.99;
  }
  EXPECT_GT(weaker, 10);
  EXPECT_GT(softer, 10);
  EXPECT_LT(std::max(weaker, softer), 90);
}

TEST(JointDamper, TakesEnergyFromFastJointsAndTouchesNoOther) {
  const ImpedanceSettings s = with_ranges(3.0, 0.4);
  JointDamper damper(s);
  const JointRange range(s);
  AnyArm any(4);
  for (int i = 0; i < 50; ++i) {
    const Posture at(any.terms(0.8));
    const JointVector tau = damper.torque(at.arm, at.space, range);
    bool fast = false;
    for (int j = 0; j < 7; ++j) {
      const double over = std::max(0.0, std::abs(at.arm.v[j]) - 0.4);
      fast |= over > 0.0;
      EXPECT_NEAR(tau[j] * at.M_inverse()(j, j),
                  -std::copysign(bearable_rate(s.timing.damping_delay()) * over, at.arm.v[j]),
                  1e-9);
    }
    EXPECT_EQ(damper.active(), fast);
  }
}

// Of an arm whose joints do not couple each comes to rest as a critically damped oscillator does.
// Joints that turn together, whose inertia is many times what each has alone.
ArmTerms coupled_arm() {
  ArmTerms arm(7);
  const Eigen::VectorXd together = Eigen::VectorXd::LinSpaced(7, 1.5, 0.5);
  arm.M = 2.0 * together * together.transpose() + 0.05 * Eigen::MatrixXd::Identity(7, 7);
  arm.J.leftCols<6>().setIdentity();
  return arm;
}

// Rates α_j, damping D, and the torque of a first step: by dense algebra.
struct BrakeOracle {
  Eigen::VectorXd rates, D;
  BrakeOracle(const Eigen::MatrixXd& M, double c, double torque_rate) : rates(7), D(7) {
    const Eigen::MatrixXd inverse = testing_arm::inverse(M);
    for (int j = 0; j < 7; ++j) {
      rates[j] =
          std::min(c, std::sqrt(JointBrake::kShare * torque_rate / JointBrake::kFast / M(j, j)));
      D[j] = std::min(c / inverse(j, j), rates[j] * M(j, j));
    }
  }
  double alpha() const { return rates.minCoeff(); }
  Eigen::VectorXd first(const Eigen::MatrixXd& M, const Eigen::VectorXd& lack, double dt) const {
    const double a = alpha();
    return (a + 0.25 * a * a * dt) * M * lack + D.cwiseProduct(lack);
  }
};

// A motion of all joints together is the slowest: v = v₀ (1 − αt/2) exp(−αt/2) until 2/α by αM and
// its integral alone. Whatever moves rests from then on.
TEST(JointBrake, BringsJointsThatTurnTogetherToRestAndStaysThere) {
  AnyArm any(11);
  for (const double torque_rate : {300.0, 1000.0, 1e9}) {
    for (int k = 0; k < 20; ++k) {
      ImpedanceSettings s;
      s.limits.torque_rate = JointVector::Constant(7, torque_rate);
      JointBrake brake(s, 7);
      ArmTerms arm = coupled_arm();
      const JointVector v_0 =
          k > 0 ? any.joints(1.0) : JointVector(Eigen::VectorXd::LinSpaced(7, 1.5, 0.5));
      arm.v = v_0;
      OperationalSpace space;
      space.update(arm);
      const BrakeOracle oracle(arm.M, bearable_rate(s.timing.damping_delay()), torque_rate);
      constexpr double dt = 1e-3;
      double energy = v_0.dot(arm.M * v_0);
      for (int i = 1; i < 1500; ++i) {
        arm.v += dt * space.acceleration(brake.torque(arm, space, Vector3d::Zero()));
        const double x = 0.5 * oracle.alpha() * (i - 1) * dt;
        if (x < 0.9) {
          const double now = arm.v.dot(arm.M * arm.v);
          ASSERT_LT(now, energy) << i;
          energy = now;
        }
        if (k == 0 && x < 1.0) {
          ASSERT_LE(arm.v.norm(), (1.0 - x) * std::exp(-x) * v_0.norm() + 0.01) << i;
        }
        if (x > 1.1) {
          ASSERT_LT(arm.v.norm(), 0.03 * v_0.norm()) << i << " at " << torque_rate;
        }
      }
      EXPECT_LT(arm.v.norm(), 2e-3);
    }
  }
}

TEST(JointBrake, HoldsAgainstAConstantTorque) {
  const ImpedanceSettings s;
  JointBrake brake(s, 7);
  ArmTerms arm = coupled_arm();
  arm.v = JointVector::Constant(7, 1.0);
  OperationalSpace space;
  space.update(arm);
  const BrakeOracle oracle(arm.M, bearable_rate(s.timing.damping_delay()), 1e9);
  for (int i = 0; i < 3000; ++i) {
    const JointVector tau = brake.torque(arm, space, Vector3d::Zero());
    if (i == 0) {
      EXPECT_LT((tau - oracle.first(arm.M, -arm.v, 1e-3)).norm(), 1e-9);
    }
    arm.v += 1e-3 * space.acceleration(tau + JointVector::Constant(7, 0.1));  // and a hand
  }
  EXPECT_LT(arm.v.norm(), 1e-6);
  EXPECT_NEAR(brake.torque(arm, space, Vector3d::Zero())[3], -0.1, 1e-3);
  brake.release();
  EXPECT_LT(brake.torque(arm, space, Vector3d::Zero()).norm(), 1e-3);
}

TEST(JointBrake, MovesTheTipAsAskedWithinWhatTheTorquesRateAllows) {
  ImpedanceSettings s;
  s.limits.torque_rate = Eigen::VectorXd::Constant(7, 100.0);
  JointBrake brake(s, 7);
  AnyArm any(5);
  const Posture at(any.terms(0.0));
  const Vector3d v_WD = 0.1 * any.direction();
  Vector6 V = Vector6::Zero();
  V.head<3>() = v_WD;
  const BrakeOracle oracle(at.arm.M, bearable_rate(s.timing.damping_delay()), 100.0);
  const Eigen::VectorXd expected = oracle.first(at.arm.M, at.J_bar() * V, s.timing.dt);
  EXPECT_LT((brake.torque(at.arm, at.space, v_WD) - expected).norm(), 1e-9);
}

// What exceeds the bound is compensated at the tip as a whole, and not where the arm moves within
// itself.
TEST(Disturbance, BeyondItsBoundTheTipFeelsNothingAndTheArmYields) {
  AnyArm any(6);
  for (int i = 0; i < 50; ++i) {
    const Posture at(any.terms());
    const JointVector r = any.joints(10.0), most = JointVector::Constant(7, 3.0);
    const Eigen::VectorXd r_y = yielding(r, most, at.arm, at.space);
    const Eigen::VectorXd r_c = r.cwiseMin(most).cwiseMax(-most);
    const Eigen::MatrixXd J_bar_T = at.J_bar().transpose();
    EXPECT_LT((J_bar_T * (r_y - Eigen::VectorXd(r))).norm(), 1e-9);
    const Eigen::MatrixXd N = Eigen::MatrixXd::Identity(7, 7) - at.arm.J.transpose() * J_bar_T;
    EXPECT_LT((N * (r_y - r_c)).norm(), 1e-9);
    EXPECT_EQ(yielding(r, JointVector::Constant(7, 11.0), at.arm, at.space), r);
  }
}

TEST(Disturbance, IsHeldWhileTheWrenchIsLostAndZeroWithoutOne) {
  ImpedanceSettings s;
  AnyArm any(7);
  Posture at(any.terms());
  at.arm.v.setZero();
  const TipReference plan;
  const SurfaceEstimate surface;
  StepInput in{at.arm, plan, surface, Wrench::Zero(), false, nullptr};
  const auto settled = [&](const ImpedanceSettings& settings) {
    Disturbance disturbance(settings, 7);
    JointVector tau;
    for (int i = 0; i < 200; ++i) {  // the arm stands, under a torque of 2 Nm too much
      tau = disturbance.compensation(in, at.space);
      disturbance.commanded(in, at.arm.Cv + at.arm.g + JointVector::Constant(7, 2.0));
    }
    in.wrench_lost = true;
    EXPECT_EQ(disturbance.compensation(in, at.space), tau);
    in.wrench_lost = false;
    return tau;
  };
  EXPECT_LT((settled(s) - JointVector::Constant(7, 2.0)).norm(), 1e-9);
  s.observer.yield_limit.assign(7, 1.0);
  const JointVector yields = settled(s);
  const JointVector most = JointVector::Ones(7) + Disturbance::kWeightShare * at.arm.g.cwiseAbs();
  EXPECT_LT((yields + yielding(JointVector::Constant(7, -2.0), most, at.arm, at.space)).norm(),
            1e-9);
  s.observer.enabled = false;
  EXPECT_EQ(settled(s).norm(), 0.0);
}

}  // namespace
}  // namespace impedraw
