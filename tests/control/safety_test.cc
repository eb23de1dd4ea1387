// Safety reactions of the controller: speed and torque rate limits, singular postures, invalid and
// stale input.
#include <cmath>

#include <gtest/gtest.h>

#include "free_arm.h"

namespace impedraw {
namespace {

using namespace testing_arm;

const double kNaN = std::nan("");

// Drives a rate-limited arm through a sequence of events and checks every torque step.
struct RateWatch {
  double allowed;
  JointVector last;
  double largest = 0.0;
  int step = 0;

  void look(const JointVector& tau, const char* where) {
    ASSERT_TRUE(tau.allFinite()) << where;
    if (last.size() > 0) largest = std::max(largest, (tau - last).cwiseAbs().maxCoeff());
    ASSERT_LE(largest, allowed + 1e-9) << where << ", step " << step;
    last = tau;
    ++step;
  }
};

// A swinging arm comes to rest; what is told meanwhile is where its pen is and points.
TEST(Brake, BringsAnArmToRestAndTellsWhereItsPenIs) {
  ArmModel arm(kArm);
  FreeArm free(shaped_settings(arm));
  JointVector v = JointVector::Zero(7);
  v[0] = 0.6;
  v[3] = -0.5;
  free.world.set_state(working_posture(), v);
  for (int i = 0; i < 800; ++i) {
    free.measure();
    const ImpedanceTorque& out = free.controller.brake(free.terms, Eigen::Vector3d::Zero());
    ASSERT_LT((out.n_WD + free.terms.X_WE.R.col(2)).norm(), 1e-12);
    ASSERT_LT((out.axis_WD + free.terms.X_WE.R.col(2)).norm(), 1e-12);
    ASSERT_EQ(out.p_WD, free.terms.X_WE.p);
    ASSERT_EQ(out.push, 0.0);
    free.move(out.tau, Wrench::Zero());
  }
  EXPECT_LT(free.world.state().v.norm(), 0.01);
}

TEST(TorqueRate, HoldsAcrossEverySwitchOfState) {
  ArmModel arm(kArm);
  for (const bool natural : {false, true}) {
    SCOPED_TRACE(natural ? "natural" : "shaped");
    ImpedanceSettings s = natural ? natural_settings(arm) : shaped_settings(arm);
    s.limits.torque_rate = Eigen::VectorXd::Constant(7, 1000.0);
    PlaneArm on(s);
    RateWatch watch{1.0, {}};
    bool seen[5] = {};
    bool limited = false;
    const auto go = [&](int steps, const char* where) {
      for (int i = 0; i < steps; ++i) {
        const ImpedanceTorque& out = on.step();
        seen[static_cast<int>(out.mode)] = true;
        limited |= out.status.torque_limited;
        watch.look(out.tau, where);
        if (testing::Test::HasFatalFailure()) return;
      }
    };
    const auto spoilt = [&](int steps, const char* where, auto&& spoil) {
      for (int i = 0; i < steps; ++i) {
        on.look();
        on.free.measure();
        const Wrench F = on.free.F_ext;
        const TipReference reference = on.free.reference;
        spoil();
        const ImpedanceTorque out = on.free.control();
        on.free.reference = reference;
        on.free.F_ext = F;
        on.free.ages = {};
        watch.look(out.tau, where);
        if (testing::Test::HasFatalFailure()) return;
        on.free.move(out.tau, Wrench::Zero());
      }
    };
    go(200, "free");
    on.free.reference.pen_down = true;
    go(1500, "approach and contact");
    on.free.reference.p_WD += Eigen::Vector3d(0.0, 0.03, 0.0);
    go(500, "a jump of the reference in contact");
    spoilt(1, "one NaN", [&] { on.free.terms.v[2] = kNaN; });
    go(1000, "after one NaN");
    spoilt(20, "NaN for 20 ms", [&] { on.free.reference.p_WD.x() = kNaN; });
    go(1000, "after NaN");
    spoilt(20, "stale state", [&] { on.free.ages.state = 1.0; });
    go(1000, "after a stale state");
    on.free.reference.pen_down = false;
    go(600, "lift");
    on.free.reference.pen_down = true;
    go(1500, "down again");
    spoilt(50, "stale wrench", [&] { on.free.ages.wrench = 1.0; });
    go(1000, "after a stale wrench");
    on.free.reference.pen_down = false;
    go(600, "up after a stale wrench");
    on.free.reference.pen_down = true;
    go(1500, "and down");
    on.free.surface.status = SurfaceStatus::too_few;
    go(600, "no surface: retreat");
    on.look();
    on.free.reference.pen_down = false;
    on.free.reference.p_WD += 0.05 * on.n_W;
    go(300, "free again");
    on.free.reference.p_WD += Eigen::Vector3d(-0.1, 0.1, 0.1);
    go(2000, "a jump of the reference");
    for (const bool mode : seen) EXPECT_TRUE(mode) << "the story misses a mode";
    EXPECT_TRUE(limited);
    EXPECT_GT(watch.largest, 0.99) << "or the limit was not needed";
    EXPECT_LT((on.free.world.state().X_WE.p - on.free.reference.p_WD).norm(), 1e-3)
        << "and the pen still is where it should be";
  }
}

TEST(TipSpeed, StaysWithinItsLimitAndTheTipArrives) {
  ArmModel arm(kArm);
  for (const bool natural : {false, true}) {
    for (const Eigen::Vector3d& way :
         {Eigen::Vector3d(0.0, 0.3, 0.0), Eigen::Vector3d(-0.15, -0.2, 0.16),
          Eigen::Vector3d(0.0, 0.0, 0.3)}) {
      SCOPED_TRACE(testing::Message()
                   << (natural ? "natural" : "shaped") << ", by " << way.transpose());
      ImpedanceSettings s = natural ? natural_settings(arm) : shaped_settings(arm);
      s.limits.tip_speed = 0.3;
      FreeArm free(s);
      free.reference.p_WD += way;
      double fastest = 0.0;
      bool told = false;
      for (int i = 0; i < 4000; ++i) {
        told |= free.step().status.speed_limited;
        fastest = std::max(fastest, free.world.state().V_WE.head<3>().norm());
      }
      EXPECT_TRUE(told);
      EXPECT_LE(fastest, 1.05 * s.limits.tip_speed);
      EXPECT_GT(fastest, 0.8 * s.limits.tip_speed) << "it need not creep either";
      EXPECT_LT((free.world.state().X_WE.p - free.reference.p_WD).norm(), 1e-3);
    }
  }
}

// A pen that slips into a gap is told to turn by tens of degrees at once. Joint 5 left its speed
// limit, and the guard ended the drawing.
TEST(JointSpeed, OfAPenThatIsToTurnAtOnceStaysWithinItsLimit) {
  ArmModel arm(kArm);
  for (const bool natural : {false, true}) {
    for (const Eigen::Vector3d& by :
         {Eigen::Vector3d(0.5, 0.0, 0.0), Eigen::Vector3d(-0.5, 0.0, 0.0),
          Eigen::Vector3d(0.0, 0.5, 0.0), Eigen::Vector3d(0.0, -0.5, 0.0)}) {
      SCOPED_TRACE(testing::Message()
                   << (natural ? "natural" : "shaped") << ", by " << by.transpose());
      ImpedanceSettings s = natural ? natural_settings(arm) : shaped_settings(arm);
      s.limits.joint_speed = arm.limits().speed;
      FreeArm free(s);
      free.reference.n_WD = Eigen::AngleAxisd(by.norm(), by.normalized()) * free.reference.n_WD;
      double share = 0.0;
      bool told = false;
      for (int i = 0; i < 3000; ++i) {
        told |= free.step().status.speed_limited;
        share = std::max(
            share, (free.world.state().v.array() / arm.limits().speed.array()).abs().maxCoeff());
      }
      EXPECT_TRUE(told);
      EXPECT_LT(share, 1.1);
      EXPECT_GT(share, 0.7) << "it need not creep either";
      EXPECT_GT(free.reference.n_WD.dot(-free.world.state().X_WE.R.col(2)), std::cos(0.01));
    }
  }
}

// Between two strokes the pen leant towards the forearm, joint 6 was nearly stretched, and the turn
// stopped or went on. Only what the turn asked of joint 5 was held within its limit: the elbow's
// own motion came on top of it.
TEST(JointSpeed, CountsTheElbowsOwnMotionWhereTheWristIsNearlyStretched) {
  constexpr int kSeed = 7, kTurns = 60;
  ArmModel arm(kArm);
  JointVector q(7), straight(7), rest(7);
  q << 0.32, 0.43, -0.26, -1.75, -0.42, 0.46, 0.44;
  rest << 0.0, 0.12, 0.0, -1.53, 0.0, 1.49, 0.0;
  straight = q;
  straight[5] = 0.0;
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> about(-1.0, 1.0);
  double slowest = 1.0;
  for (int k = 0; k < kTurns; ++k) {
    SCOPED_TRACE(testing::Message() << "seed " << kSeed << ", turn " << k);
    ImpedanceSettings s = k % 2 ? natural_settings(arm) : shaped_settings(arm);
    s.limits.joint_speed = arm.limits().speed;
    s.null_space.q_0 = rest;
    FreeArm free(s, q);
    const Eigen::Vector3d n = free.reference.n_WD,
                          forearm = -FreeArm(s, straight).terms.X_WE.R.col(2);
    // past the forearm's direction, by up to 0.1
    const Eigen::Vector3d axis =
        (n.cross(forearm).normalized() + 0.1 * about(rng) * forearm).normalized();
    const double total = 0.8 + 0.3 * about(rng), rate = 0.5 + 0.15 * about(rng);  // [rad], [rad/s]
    const double stop = k % 3 ? 0.45 + 0.15 * about(rng) : total;  // for a while [rad]
    double share = 0.0, angle = 0.0, clock = 1.0;
    for (int i = 0; i < 5000; ++i) {
      const bool goes = angle < total && (angle < stop || i >= 3000);
      clock += std::clamp((goes ? 1.0 : 0.0) - clock, -0.01, 0.003);
      angle = std::min(total, angle + 1e-3 * clock * rate);
      free.reference.n_WD = Eigen::AngleAxisd(angle, axis) * n;
      free.reference.w_WD = (angle < total ? clock * rate : 0.0) * axis;
      free.step();
      share = std::max(
          share, (free.world.state().v.array() / arm.limits().speed.array()).abs().maxCoeff());
    }
    EXPECT_LT(share, 1.2);
    slowest = std::min(slowest, share);
  }
  EXPECT_GT(slowest, 0.5) << "it need not creep either";
}

// A pen that came down beside an edge was to turn on and on. Joint 6 ran into its end, its torque
// grew to the limit, and the other joints swung.
TEST(JointRange, AJointThatIsToGoBeyondItsEndComesToRestBeforeIt) {
  ArmModel arm(kArm);
  for (const bool natural : {false, true}) {
    for (const double by : {1.0, -1.0}) {
      SCOPED_TRACE(testing::Message() << (natural ? "natural" : "shaped") << ", by " << by);
      ImpedanceSettings s = natural ? natural_settings(arm) : shaped_settings(arm);
      s.limits.joint_speed = arm.limits().speed;
      s.joint_range.lower = arm.limits().lower;
      s.joint_range.upper = arm.limits().upper;
      const double start = FreeArm(s).world.state().q[5];
      s.joint_range.lower[5] = start - 0.3;
      s.joint_range.upper[5] = start + 0.3;
      FreeArm free(s);
      free.reference.n_WD = Eigen::AngleAxisd(by, Eigen::Vector3d::UnitY()) * free.reference.n_WD;
      double furthest = 0.0;
      for (int i = 0; i < 4000; ++i) {
        free.step();
        furthest = std::max(furthest, std::abs(free.world.state().q[5] - start));
      }
      EXPECT_LT(furthest, 0.3);
      EXPECT_GT(furthest, 0.2) << "or it is not to go there";
      EXPECT_LT(free.world.state().v.cwiseAbs().maxCoeff(), 0.02) << "and it rests";
    }
  }
}

TEST(SingularPosture, IsPassedWithinTheArmsOwnTorque) {
  ArmModel arm(kArm);
  JointVector q(7);
  q << 0.0, 0.9, 0.0, -0.6, 0.0, 0.5, 0.0;
  for (const bool natural : {false, true}) {
    ImpedanceSettings s = natural ? natural_settings(arm) : shaped_settings(arm);
    s.null_space.q_0 = q;
    // 5000 is enough, 3000 is not: Λ changes fast here
    s.limits.torque_rate = Eigen::VectorXd::Constant(7, 10000.0);
    FreeArm free(s, q);
    const Eigen::Vector3d start = free.reference.p_WD,
                          outward = (start - Eigen::Vector3d(0.0, 0.0, 0.36)).normalized();
    bool told = false;
    RateWatch watch{10.0, {}};
    for (int i = 0; i < 4000; ++i) {  // out to beyond the arm's reach, and back
      const double way = 0.1e-3 * (i < 2000 ? i : 4000 - i);
      free.reference.p_WD = start + way * outward;
      free.reference.v_WD = (i < 2000 ? 0.1 : -0.1) * outward;
      const ImpedanceTorque& out = free.step();
      told |= out.status.near_singular;
      watch.look(out.tau, "stretched");
      if (HasFatalFailure()) return;
      ASSERT_LE((out.tau.cwiseAbs() - s.limits.torque).maxCoeff(), 0.0);
      ASSERT_FALSE(free.world.failure()) << *free.world.failure();
    }
    EXPECT_TRUE(told);
    free.reference.v_WD.setZero();
    for (int i = 0; i < 1000; ++i) free.step();
    EXPECT_LT((free.world.state().X_WE.p - start).norm(), 1e-3) << "and it comes back";
  }
}

TEST(BadInput, GoesToTheLastGravityTorqueAsFastAsTheRateLets) {
  ArmModel arm(kArm);
  for (const bool stale : {false, true}) {
    ImpedanceSettings s = shaped_settings(arm);
    s.limits.torque_rate = Eigen::VectorXd::Constant(7, 500.0);
    FreeArm free(s);
    free.reference.p_WD += Eigen::Vector3d(0.05, -0.05, 0.05);
    for (int i = 0; i < 60; ++i) free.step();
    JointVector left = free.control().tau - free.terms.g;
    const JointVector gravity = free.terms.g;
    ASSERT_GT(left.cwiseAbs().maxCoeff(), 3.0);
    for (int i = 0; i < 200; ++i) {
      if (stale)
        free.ages.state = 0.1;
      else
        free.terms.q[1] = free.terms.g[1] = kNaN;
      const ImpedanceTorque& out = free.control();
      ASSERT_EQ(out.status.stale_state, stale);
      ASSERT_EQ(out.status.bad_input, !stale);
      ASSERT_FALSE(out.status.ok());
      left = left.unaryExpr(
          [](double x) { return std::copysign(std::max(0.0, std::abs(x) - 0.5), x); });
      ASSERT_LT((out.tau - gravity - left).norm(), 1e-9) << "after " << i << " steps";
    }
    EXPECT_EQ(left.norm(), 0.0);
  }
}

TEST(BadInput, AnAgeThatIsNotANumberIsTooOld) {
  ArmModel arm(kArm);
  FreeArm free(shaped_settings(arm));
  free.ages.state = kNaN;
  EXPECT_TRUE(free.control().status.stale_state);
  free.ages = {0.0, kNaN};
  EXPECT_TRUE(free.control().status.stale_wrench);
  const TimingSettings timing;
  free.ages = {timing.max_state_age, timing.max_wrench_age};
  EXPECT_TRUE(free.control().status.ok()) << "old, but not too old";
}

TEST(StaleWrench, EndsTheContactUntilThePenWasUp) {
  ArmModel arm(kArm);
  PlaneArm on(shaped_settings(arm));
  on.draw();
  ASSERT_EQ(on.step().mode, ContactMode::contact);
  on.free.ages.wrench = 0.05;
  for (int i = 0; i < 400; ++i) {
    const ImpedanceTorque& out = on.step();
    ASSERT_EQ(out.mode, ContactMode::retreat);
    ASSERT_EQ(out.push, 0.0);
    ASSERT_TRUE(out.status.stale_wrench);
  }
  EXPECT_GT(on.height(), 0.015) << "it is off the surface, by nearly retreat_height";
  on.free.ages.wrench = 0.0;
  for (int i = 0; i < 300; ++i)
    ASSERT_EQ(on.step().mode, ContactMode::retreat) << "the wrench is back, the pen was not lifted";
  on.free.reference.pen_down = false;
  for (int i = 0; i < 300; ++i) ASSERT_EQ(on.step().mode, ContactMode::free);
  on.draw();
  EXPECT_EQ(on.step().mode, ContactMode::contact);
}

// Motion during a missing wrench must not count as a disturbance when the wrench returns.
TEST(StaleWrench, LeavesTheObserverInPeace) {
  ArmModel arm(kArm);
  ImpedanceSettings s = shaped_settings(arm);
  FreeArm free(s);
  ASSERT_TRUE(s.observer.enabled);
  double largest = 0.0;
  for (int i = 0; i < 600; ++i) {
    if (i == 100)
      free.reference.p_WD +=
          Eigen::Vector3d(0.05, -0.05, 0.05);  // it moves while the wrench is missing
    free.ages.wrench = i > 100 && i < 160 ? 1.0 : 0.0;
    largest = std::max(largest, free.step().terms.col(kDisturbance).cwiseAbs().maxCoeff());
  }
  EXPECT_LT(largest, 0.2) << "[Nm] on an arm that is as the model says";
}

TEST(LostCloud, EndsInRetreat) {
  ArmModel arm(kArm);
  const ImpedanceSettings s = shaped_settings(arm);
  PlaneArm on(s);
  on.draw();
  ASSERT_EQ(on.step().mode, ContactMode::contact);
  on.free.surface.status = SurfaceStatus::off_edge;
  on.free.surface.n_W = Eigen::Vector3d::UnitX();
  on.free.surface.distance = kNaN;
  const int trusted = static_cast<int>(s.contact.lost_surface_time / s.timing.dt);
  for (int i = 0; i < trusted - 2; ++i) {
    const ImpedanceTorque& out = on.step();
    ASSERT_TRUE(out.status.surface_lost);
    ASSERT_EQ(out.mode, ContactMode::contact);
    ASSERT_NEAR(on.n_W.dot(on.free.F_ext.head<3>()), s.normal_force, 0.25)
        << "on the last normal the push goes on";
  }
  for (int i = 0; i < 500; ++i) on.step();
  EXPECT_EQ(on.step().mode, ContactMode::retreat);
  EXPECT_GT(on.height(), 0.015);
  EXPECT_EQ(on.free.F_ext.norm(), 0.0);
}

}  // namespace
}  // namespace impedraw
