// Torque limits against brute force: every vertex of the small linear program for the share of the
// task.
#include "impedraw/control/torque_limits.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "arm_fixture.h"
#include "dense_algebra.h"

namespace impedraw {
namespace {

using namespace testing_arm;

constexpr double kDt = 1e-3;
const Eigen::VectorXd kNoRate;

// The elbow alone sets the distance from wrist to shoulder, so it does not move in this arm's null
// space. A null-space torque acts on it only through inertia, with a factor of a hundredth: 2 Nm
// there would cost 200 Nm elsewhere. It has its own test below.
constexpr int kElbow = 3;

// A posture, its operational space, and the direction of its null-space torques by the textbook
struct Posture {
  ArmTerms terms{7};
  OperationalSpace space;
  Eigen::MatrixXd tip_of;  // J̄ᵀ, 6×7, by full inverses
  Eigen::VectorXd d;       // null-space torque, unit length

  Posture(ArmModel& arm, std::mt19937& rng) {
    do terms = random_terms(arm, rng);
    while (!space.update(terms));
    const Eigen::MatrixXd J = terms.J, M_inverse = inverse(terms.M);
    tip_of = inverse(J * M_inverse * J.transpose()) * J * M_inverse;
    const Eigen::MatrixXd N = Eigen::MatrixXd::Identity(7, 7) - J.transpose() * tip_of;
    Eigen::Index best = 0;
    N.colwise().norm().maxCoeff(&best);
    d = N.col(best).normalized();
  }
};

struct Torques {
  JointVector hold{7}, task{7}, null{7};

  Torques(const Posture& p, std::mt19937& rng, double task_size, double null_size) {
    std::normal_distribution<double> normal;
    Vector6 F;
    for (int i = 0; i < 6; ++i) F[i] = task_size * normal(rng) * (i < 3 ? 1.0 : 0.1);
    hold = p.terms.g;
    task = p.terms.J.transpose() * F;
    null = null_size * normal(rng) * p.d;
  }
  JointVector sum() const { return hold + task + null; }
};

struct Best {
  bool feasible = false;
  double share = -1.0, alpha = 0.0;  // the largest s, and with it the least |α|
};

// max s over 0 ≤ s ≤ 1, lower ≤ base + s task + α d ≤ upper: all intersections of two constraints,
// and the best feasible one.
Best brute_force(const JointVector& base, const JointVector& task, const Eigen::VectorXd& d,
                 const JointVector& lower, const JointVector& upper) {
  struct Line {
    double s, alpha, limit;  // s x + alpha y ≤ limit
  };
  std::vector<Line> lines{{1, 0, 1}, {-1, 0, 0}};
  for (int i = 0; i < 7; ++i) {
    lines.push_back({task[i], d[i], upper[i] - base[i]});
    lines.push_back({-task[i], -d[i], base[i] - lower[i]});
  }
  Best best;
  const auto consider = [&](double s, double alpha) {
    for (const Line& l : lines)
      if (l.s * s + l.alpha * alpha > l.limit + 1e-9) return;
    best.feasible = true;
    if (s > best.share + 1e-9 || (s > best.share - 1e-9 && std::abs(alpha) < std::abs(best.alpha)))
      best.alpha = alpha;
    best.share = std::max(best.share, s);
  };
  for (const Line& a : lines) {
    if (std::abs(a.s) > 1e-12) consider(a.limit / a.s, 0.0);  // no shift at all
    for (const Line& b : lines) {
      const double det = a.s * b.alpha - a.alpha * b.s;
      if (std::abs(det) > 1e-12)
        consider((a.limit * b.alpha - a.alpha * b.limit) / det,
                 (a.s * b.limit - a.limit * b.s) / det);
    }
  }
  return best;
}

TEST(TorqueLimits, LeaveAloneWhatIsInside) {
  ArmModel arm(kArm);
  std::mt19937 rng(1);
  for (int i = 0; i < 50; ++i) {
    const Posture p(arm, rng);
    const Torques t(p, rng, 20.0, 5.0);
    TorqueLimits limits(t.sum().cwiseAbs() + JointVector::Constant(7, 1e-6), kNoRate, kDt);
    const LimitedTorque out = limits.apply(t.hold, t.task, t.null, p.terms, p.space);
    EXPECT_FALSE(out.limited);
    EXPECT_EQ(out.task_share, 1.0);
    EXPECT_EQ((out.tau - t.sum()).norm(), 0.0);
  }
}

TEST(TorqueLimits, AJointThatIsOutIsReliedOnTheNullSpace) {
  ArmModel arm(kArm);
  const unsigned seed = 2;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int shifted = 0;
  for (int i = 0; i < 300; ++i) {
    const Posture p(arm, rng);
    const Torques t(p, rng, 20.0, 5.0);
    Eigen::VectorXd limit = Eigen::VectorXd::Constant(7, 1e3);
    const int joint = i % 7;
    if (joint == kElbow) continue;
    limit[joint] = (0.8 + 0.19 * unit(rng)) * std::abs(t.sum()[joint]);
    TorqueLimits limits(limit, kNoRate, kDt);
    const LimitedTorque out = limits.apply(t.hold, t.task, t.null, p.terms, p.space);
    ASSERT_TRUE(out.limited);
    const Best best = brute_force(t.hold + t.null, t.task, p.d, -limit, limit);
    if (!best.feasible || best.share < 1.0) continue;
    ++shifted;
    EXPECT_EQ(out.task_share, 1.0);
    EXPECT_LE((out.tau.cwiseAbs() - limit).maxCoeff(), 0.0);
    EXPECT_LT((p.tip_of * (out.tau - t.sum())).norm(), 1e-9 * (1.0 + (p.tip_of * t.sum()).norm()))
        << "the tip feels nothing of it";
    EXPECT_NEAR((out.tau - t.sum()).norm(), std::abs(best.alpha),
                1e-7 * (1.0 + std::abs(best.alpha)))
        << "and it is the least that will do";
    // The defect: each joint clipped independently.
    const JointVector clipped = t.sum().cwiseMax(-limit).cwiseMin(limit);
    EXPECT_GT((p.tip_of * (clipped - t.sum())).norm(), 1e-6);
  }
  EXPECT_GT(shifted, 100);
}

TEST(TorqueLimits, KeepAsMuchOfTheTaskAsCanBe) {
  ArmModel arm(kArm);
  const unsigned seed = 3;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int scaled = 0;
  for (int i = 0; i < 500; ++i) {
    const Posture p(arm, rng);
    const Torques t(p, rng, 100.0, 5.0);
    Eigen::VectorXd limit(7);
    for (int j = 0; j < 7; ++j) limit[j] = std::abs(p.terms.g[j]) + 2.0 + 30.0 * unit(rng);
    limit[kElbow] = 1e3;
    TorqueLimits limits(limit, kNoRate, kDt);
    const LimitedTorque out = limits.apply(t.hold, t.task, t.null, p.terms, p.space);
    EXPECT_LE((out.tau.cwiseAbs() - limit).maxCoeff(), 0.0);
    const Best best = brute_force(t.hold + t.null, t.task, p.d, -limit, limit);
    if (!best.feasible || best.share > 1.0 - 1e-6) continue;
    ++scaled;
    EXPECT_NEAR(out.task_share, best.share, 2e-3);
    const Vector6 kept = p.tip_of * (out.tau - t.hold), asked = p.tip_of * t.task;
    EXPECT_LT((kept - out.task_share * asked).norm(), 1e-9 * (1.0 + asked.norm()))
        << "the wrench keeps its direction";
  }
  EXPECT_GT(scaled, 200);
}

TEST(TorqueLimits, DoNotThrowTheArmAboutForItsElbow) {
  ArmModel arm(kArm);
  const unsigned seed = 9;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  int scaled = 0;
  for (int i = 0; i < 100; ++i) {
    const Posture p(arm, rng);
    const Torques t(p, rng, 50.0, 2.0);
    Eigen::VectorXd limit = Eigen::VectorXd::Constant(7, 1e3);
    limit[kElbow] = std::abs(p.terms.g[kElbow]) + 0.5 * std::abs(t.task[kElbow]);
    const Best without_shift =
        brute_force(t.hold + t.null, t.task, Eigen::VectorXd::Zero(7), -limit, limit);
    if (!without_shift.feasible || without_shift.share > 1.0 - 1e-6) continue;
    ++scaled;
    TorqueLimits limits(limit, kNoRate, kDt);
    const LimitedTorque out = limits.apply(t.hold, t.task, t.null, p.terms, p.space);
    EXPECT_NEAR(out.task_share, without_shift.share, 2e-3);
    EXPECT_LT((out.tau - t.hold - out.task_share * t.task - t.null).norm(), 1e-6);
  }
  EXPECT_GT(scaled, 20);
}

// Within the rates, the torque's acceleration is nearest to what was asked: Kuhn and Tucker's
// conditions of min (τ − asked)ᵀ M⁻¹ (τ − asked), with M inverted by Eigen. The defect: each joint
// clipped by itself, and base joints that lacked 100 Nm threw the wrist about at 20 rad/s.
TEST(TorqueLimits, TheRateIsSharedByLeastConstraint) {
  ArmModel arm(kArm);
  const unsigned seed = 4;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  const Eigen::VectorXd limit = Eigen::VectorXd::Constant(7, 1e3),
                        rate = Eigen::VectorXd::Constant(7, 1000.0);
  const double step = 1000.0 * kDt;
  int clipped = 0, free = 0;
  for (int i = 0; i < 300; ++i) {
    const Posture p(arm, rng);
    const Torques t(p, rng, 50.0, 2.0);
    TorqueLimits limits(limit, rate, kDt);
    const JointVector last = limits.apply(t.hold, t.task, t.null, p.terms, p.space).tau;
    const JointVector more = 1.1 * t.task, asked = t.hold + more + t.null;
    const LimitedTorque out = limits.apply(t.hold, more, t.null, p.terms, p.space);
    EXPECT_EQ(out.task_share, 1.0);
    EXPECT_EQ(out.limited, (asked - last).cwiseAbs().maxCoeff() > step);
    const Eigen::MatrixXd inverse = Eigen::MatrixXd(p.terms.M).inverse();
    const Eigen::VectorXd slope = inverse * (out.tau - asked),
                          by_clipping =
                              (asked - last).cwiseMax(-step).cwiseMin(step) - (asked - last);
    EXPECT_LE((out.tau - asked).dot(slope), by_clipping.dot(inverse * by_clipping) + 1e-9);
    for (int j = 0; j < 7; ++j) {
      const double change = out.tau[j] - last[j], further = -slope[j] / inverse(j, j);
      ASSERT_LE(std::abs(change), step + 1e-12);
      const bool at_end = std::abs(change) > step - 1e-12;
      (at_end ? clipped : free) += 1;
      if (at_end)
        EXPECT_GT(further * change, -1e-9) << "it would turn back";
      else
        EXPECT_NEAR(further, 0.0, 1e-7) << "it would go on [Nm]";
    }
  }
  EXPECT_GT(clipped, 200);
  EXPECT_GT(free, 200);
}

// A direction that counts most: the metric's inverse is M⁻¹ + 9 Λ a aᵀ, a = M⁻¹ Jᵀ n, Λ = 1/(nᵀ J
// a), and by random torques within the rates none is nearer. The defect: a canvas that rises at 75
// mm/s pressed with 13 N, because the torque built up as if the pen's tilt counted as much.
TEST(TorqueLimits, AFirstDirectionLacksLess) {
  ArmModel arm(kArm);
  const unsigned seed = 5;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  const Eigen::VectorXd limit = Eigen::VectorXd::Constant(7, 1e3),
                        rate = Eigen::VectorXd::Constant(7, 1000.0);
  double with = 0.0, without = 0.0;
  for (int i = 0; i < 200; ++i) {
    const Posture p(arm, rng);
    const Torques t(p, rng, 50.0, 2.0);
    const Eigen::Vector3d n = p.terms.X_WE.R.col(2);
    TorqueLimits limits(limit, rate, kDt), plain(limit, rate, kDt);
    const JointVector last = limits.apply(t.hold, t.task, t.null, p.terms, p.space, n, 0.9).tau;
    plain.apply(t.hold, t.task, t.null, p.terms, p.space);
    const JointVector more = 1.2 * t.task, asked = t.hold + more + t.null;
    const JointVector tau = limits.apply(t.hold, more, t.null, p.terms, p.space, n, 0.9).tau;
    const JointVector other = plain.apply(t.hold, more, t.null, p.terms, p.space).tau;
    const Eigen::MatrixXd inverse = Eigen::MatrixXd(p.terms.M).inverse();
    const Eigen::VectorXd g = p.terms.J.topRows<3>().transpose() * n, a = inverse * g;
    const Eigen::MatrixXd metric = inverse + 9.0 / g.dot(a) * a * a.transpose();
    const auto off = [&](const Eigen::VectorXd& x) {
      return (x - asked).dot(metric * (x - asked));
    };
    EXPECT_LE((tau - last).cwiseAbs().maxCoeff(), 1.0 + 1e-12);
    EXPECT_LE(off(tau), off(other) + 1e-9);
    for (int k = 0; k < 200; ++k) {
      Eigen::VectorXd within = last;
      for (int j = 0; j < 7; ++j) within[j] += part(rng);
      EXPECT_GE(off(within), off(tau) - 1e-9);
    }
    with += std::abs(a.dot(tau - asked));
    without += std::abs(a.dot(other - asked));
  }
  EXPECT_LT(with, 0.8 * without);
}

TEST(TorqueLimits, TheFirstTorqueHasNoPredecessorNorHasTheOneAfterReset) {
  ArmModel arm(kArm);
  std::mt19937 rng(5);
  const Posture p(arm, rng);
  const Torques t(p, rng, 50.0, 2.0);
  TorqueLimits limits(Eigen::VectorXd::Constant(7, 1e3), Eigen::VectorXd::Constant(7, 10.0), kDt);
  EXPECT_FALSE(limits.apply(t.hold, t.task, t.null, p.terms, p.space).limited);
  EXPECT_TRUE(limits.apply(t.hold, -t.task, t.null, p.terms, p.space).limited);
  limits.reset();
  EXPECT_FALSE(limits.apply(t.hold, -t.task, t.null, p.terms, p.space).limited);
}

TEST(TorqueLimits, ClipWhereEvenHoldingIsTooMuch) {
  ArmModel arm(kArm);
  std::mt19937 rng(6);
  const Posture p(arm, rng);
  const Torques t(p, rng, 0.0, 0.0);
  const Eigen::VectorXd limit = 0.5 * p.terms.g.cwiseAbs() + Eigen::VectorXd::Constant(7, 0.01);
  ASSERT_FALSE(brute_force(t.hold, JointVector::Zero(7), p.d, -limit, limit).feasible);
  TorqueLimits limits(limit, kNoRate, kDt);
  const LimitedTorque out =
      limits.apply(t.hold, JointVector::Zero(7), JointVector::Zero(7), p.terms, p.space);
  EXPECT_TRUE(out.limited);
  EXPECT_LT((out.tau - t.hold.cwiseMax(-limit).cwiseMin(limit)).norm(), 1e-12);
  TorqueLimits other(limit, kNoRate, kDt);
  EXPECT_EQ((other.clip(t.hold).tau - out.tau).norm(), 0.0);
}

TEST(TorqueLimits, NothingLeavesTheBox) {
  ArmModel arm(kArm);
  const unsigned seed = 7;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int arm_no = 0; arm_no < 20; ++arm_no) {
    Eigen::VectorXd limit(7), rate(7);
    for (int j = 0; j < 7; ++j) {
      limit[j] = 1.0 + 60.0 * unit(rng);
      rate[j] = 100.0 + 5000.0 * unit(rng);
    }
    TorqueLimits limits(limit, rate, kDt);
    JointVector last;
    for (int i = 0; i < 100; ++i) {
      const Posture p(arm, rng);
      const Torques t(p, rng, std::pow(10.0, 4.0 * unit(rng)), std::pow(10.0, 4.0 * unit(rng)));
      const LimitedTorque out = i % 10 == 9
                                    ? limits.clip(t.sum())
                                    : limits.apply(t.hold, t.task, t.null, p.terms, p.space);
      ASSERT_TRUE(out.tau.allFinite());
      ASSERT_LE((out.tau.cwiseAbs() - limit).maxCoeff(), 0.0);
      if (i > 0) {
        ASSERT_LE(((out.tau - last).cwiseAbs() - rate * kDt).maxCoeff(), 1e-12);
      }
      ASSERT_GE(out.task_share, 0.0);
      ASSERT_LE(out.task_share, 1.0);
      last = out.tau;
    }
  }
}

TEST(TorqueLimits, AnArmWithoutNullSpaceScalesItsTask) {
  // With six joints every torque is a wrench at the tip, so nothing can be shifted. This arm is the
  // iiwa with one joint fixed.
  ArmModel arm(kArm);
  std::mt19937 rng(8);
  int scaled = 0;
  for (int i = 0; i < 50; ++i) {
    const Posture p(arm, rng);
    ArmTerms six(6);
    for (int a = 0, from = 0; a < 6; ++a, ++from) {
      from += from == 2;
      six.J.col(a) = p.terms.J.col(from);
      for (int b = 0, other = 0; b < 6; ++b, ++other) {
        other += other == 2;
        six.M(a, b) = p.terms.M(from, other);
      }
    }
    OperationalSpace space;
    if (!space.update(six)) continue;
    const Vector6 F = Vector6::Random() * 20.0;
    const JointVector task = six.J.transpose() * F, none = JointVector::Zero(6);
    const double share = 0.25 + 0.1 * (i % 5);
    Eigen::VectorXd limit = Eigen::VectorXd::Constant(6, 1e3);
    limit[i % 6] = share * std::abs(task[i % 6]);
    TorqueLimits limits(limit, kNoRate, kDt);
    const LimitedTorque out = limits.apply(none, task, none, six, space);
    ++scaled;
    EXPECT_NEAR(out.task_share, share, 2e-3);
    EXPECT_LT((out.tau - out.task_share * task).norm(), 1e-6 * task.norm());
  }
  EXPECT_GT(scaled, 20);
}

}  // namespace
}  // namespace impedraw
