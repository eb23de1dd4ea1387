// Mode and normal of the contact: which side of a thin body, the approach, and the rise of a
// surface that moves.
#include "impedraw/control/contact.h"

#include <cmath>

#include <gtest/gtest.h>

#include "any_arm.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
using testing_arm::AnyArm;

// A tip above a plane z = 0 that the plan knows, with its wrench measured.
struct OverAPlane {
  ArmTerms arm{7};
  TipReference plan;
  SurfaceEstimate surface;
  Wrench F_ext = Wrench::Zero();
  FrameMotion carrier;
  bool carried = true, wrench_lost = false;
  ImpedanceSettings settings;
  SurfaceContact contact;

  explicit OverAPlane(const ImpedanceSettings& s = {}) : settings(s), contact(s) {
    plan.pen_down = true;
    surface.status = SurfaceStatus::ok;
    surface.distance = 0.0;
  }
  const Contact& step() {
    return contact.update({arm, plan, surface, F_ext, wrench_lost, carried ? &carrier : nullptr});
  }
  void touch() {
    F_ext[2] = 5.0;
    step();
    ASSERT_EQ(step().mode, ContactMode::contact);
  }
};

TEST(SurfaceContact, LearnsHowFastTheSurfaceRisesBeyondItsCarrier) {
  for (const double speed : {0.02, -0.02}) {
    OverAPlane over;
    over.carrier.v = {0.1, 0.0, 0.5 * speed};
    over.arm.V_WE.head<3>() = over.carrier.v;
    over.touch();
    over.arm.V_WE.head<3>() = Vector3d(0.05, 0.0, 1.5 * speed);
    const double dt = over.settings.timing.dt;
    double expected = 0.0;
    for (int i = 0; i < 100; ++i) {
      expected += SurfaceContact::kRiseRate * dt * (speed - expected);
      ASSERT_NEAR(over.step().rise, expected, 1e-12);
    }
    EXPECT_NEAR(expected, speed, 1e-3 * std::abs(speed));
    over.arm.V_WE[2] = 5.0;
    for (int i = 0; i < 100; ++i) over.step();
    EXPECT_EQ(over.step().rise, SurfaceContact::kFastestRise);
    over.carried = false;
    EXPECT_EQ(over.step().rise, 0.0) << "a canvas that stands does not rise";
  }
}

// The estimate's corrections: v_K jumps, and its acceleration does not say so. V_d along n is
// v_K + rise.
TEST(SurfaceContact, CorrectionsOfTheCarrierDoNotThrowThePen) {
  OverAPlane over;
  over.touch();
  const double dt = over.settings.timing.dt;
  over.carrier.v = {0.0, 0.3, -0.15};
  EXPECT_NEAR(over.step().rise, 0.15, 1e-3) << "the tip in contact stands, and is to stand";
  // In approach it yields to the estimate within 70 ms.
  over.F_ext.setZero();
  over.surface.distance = 5e-3;
  while (over.step().mode == ContactMode::contact) {
  }
  over.carrier.v[2] -= 0.1;
  const double before = over.step().rise;
  EXPECT_GT(before, 0.2);
  for (int i = 0; i < 70; ++i) over.step();
  EXPECT_NEAR(over.step().rise / before, std::exp(-15.0 * 71 * dt), 0.01);
  // A motion that its acceleration explains is followed at once.
  OverAPlane heaving;
  heaving.touch();
  for (int i = 0; i < 100; ++i) {
    heaving.carrier.a[2] = 2.0;
    heaving.carrier.v[2] += 2.0 * dt;
    heaving.arm.V_WE.head<3>() = heaving.carrier.v;
    EXPECT_NEAR(heaving.step().rise, 0.0, 1e-9);
  }
}

// A canvas in motion lies where the pen feels it, however far from there it is thought to be.
TEST(SurfaceContact, AFirmTouchOutranksALateEstimateOfACarrier) {
  for (const bool carried : {true, false}) {
    OverAPlane over;
    over.carried = carried;
    over.surface.distance = 9e-3;
    over.step();
    over.F_ext[2] = 4.0;
    EXPECT_EQ(over.step().mode, carried ? ContactMode::contact : ContactMode::approach);
  }
}

TEST(SurfaceContact, TurnsTheOtherSideOfAThinBody) {
  OverAPlane over;
  over.touch();
  const Vector3d n = over.step().n;
  over.surface.n_W = Vector3d(0.3, 0.0, -1.0).normalized();
  over.plan.n_WD = Vector3d(-0.3, 0.0, 1.0).normalized();
  over.surface.distance = 1e-4;
  for (int i = 0; i < 500; ++i) over.step();
  EXPECT_LT((over.step().n + over.surface.n_W).norm(), 1e-6);
  EXPECT_LT((n - Vector3d::UnitZ()).norm(), 1e-6);
  // An estimate that leans by less than 120° is believed.
  OverAPlane leaning;
  leaning.touch();
  leaning.surface.n_W = Vector3d(1.0, 0.0, -0.4).normalized();
  for (int i = 0; i < 500; ++i) leaning.step();
  EXPECT_LT((leaning.step().n - leaning.surface.n_W).norm(), 1e-6);
}

TEST(SurfaceContact, ApproachesAtItsSpeedWaitsForATipThatIsHeldAndEndsBeneathTheSurface) {
  OverAPlane over;
  const ApproachSettings& approach = over.settings.approach;
  const double dt = over.settings.timing.dt;
  over.surface.distance = 5e-3;
  for (int i = 1; i <= 300; ++i) {  // the tip is held; the desired distance runs ahead by `lag`
    const Contact& now = over.step();
    ASSERT_EQ(now.mode, ContactMode::approach);
    ASSERT_GE(now.off_target, -approach.lag - approach.speed * dt - 1e-12);
    if (i * approach.speed * dt < approach.lag) {
      ASSERT_EQ(now.sinking, approach.speed);
      ASSERT_NEAR(now.off_target, -i * approach.speed * dt, 1e-12);
    } else {
      ASSERT_NEAR(now.off_target, -approach.lag, approach.speed * dt + 1e-12);
    }
  }
  EXPECT_NEAR(over.step().off_target, -approach.lag, approach.speed * dt + 1e-12);
  double desired = 1.0;
  for (int i = 0; i < 2000; ++i) {  // the tip follows
    const Contact& now = over.step();
    desired = over.surface.distance + now.off_target;
    over.surface.distance = desired;
  }
  EXPECT_NEAR(desired, -approach.overtravel, approach.speed * dt);
  EXPECT_EQ(over.step().sinking, 0.0);
}

TEST(SurfaceContact, FollowsThePlansNormalAwayFromTheSurface) {
  AnyArm any(1);
  OverAPlane over;
  over.plan.pen_down = false;
  over.plan.n_WD = any.direction();
  const Contact& now = over.step();
  EXPECT_EQ(now.mode, ContactMode::free);
  EXPECT_EQ(now.n, over.plan.n_WD);
  EXPECT_FALSE(now.surface_lost);
  over.plan.pen_down = true;
  over.surface.status = SurfaceStatus::off_edge;
  EXPECT_TRUE(over.step().surface_lost);
  over.surface.status = SurfaceStatus::none;
  EXPECT_FALSE(over.step().surface_lost) << "there is no perception that could have lost it";
}

// The measured force leans by 0.6 to the side of the slip; perception sees no slope.
TEST(SurfaceContact, WhatIsFeltCorrectsTheNormalAndTellsWhereTheBallTouches) {
  ImpedanceSettings s;
  s.felt_normal.share = 0.5;
  OverAPlane over(s);
  over.touch();
  over.arm.V_WE[1] = 0.05;
  over.F_ext.head<3>() = Vector3d(3.0, 0.0, 5.0);
  for (int i = 0; i < 200; ++i) over.step();
  const Contact& now = over.step();
  EXPECT_GT(now.n.x(), 0.05);
  EXPECT_GT(now.n_C.x(), now.n.x());
  EXPECT_LT((now.n_T - Vector3d::UnitZ()).norm(), 1e-9) << "the pen's axis does not follow it";
  over.contact.reset();
  over.F_ext.setZero();
  const Contact& after = over.step();
  EXPECT_EQ(after.n_C, after.n);
}

TEST(SurfaceContact, AnEstimateOfTheOtherSideIsTheSameSurface) {
  OverAPlane same, other;
  same.surface.distance = 5e-3;
  other.surface.distance = -5e-3;
  other.surface.n_W = -same.surface.n_W;
  for (int i = 0; i < 50; ++i) {
    const Contact &a = same.step(), &b = other.step();
    ASSERT_EQ(b.mode, a.mode);
    ASSERT_EQ(b.sinking, a.sinking);
    ASSERT_EQ(b.off_target, a.off_target);
  }
}

TEST(SurfaceContact, ThePlansForceOutranksTheSettings) {
  OverAPlane over;
  EXPECT_EQ(over.step().force, over.settings.normal_force);
  over.plan.force = 0.5 * over.settings.normal_force;
  EXPECT_EQ(over.step().force, over.plan.force);
}

TEST(SurfaceContact, WithoutAWrenchATipThatLagsBehindTheApproachTouches) {
  ImpedanceSettings s;
  s.wrench = WrenchFeedback::none;
  OverAPlane over(s);
  over.surface.distance = 0.9 * s.contact.enter_distance;
  int steps = 0;
  while (over.step().mode != ContactMode::contact) ASSERT_LT(++steps, 1000);
  EXPECT_NEAR(steps * s.approach.speed * s.timing.dt, s.contact.touch_gap,
              2.0 * s.approach.speed * s.timing.dt);
}

TEST(SurfaceContact, AFirmTouchHoldsWhileALateEstimateOfACarrierLiesFarOff) {
  for (const double distance : {-9e-3, -2e-3, 2e-3}) {
    OverAPlane over;
    over.F_ext[2] = 1.0;
    for (int i = 0; i < 2; ++i) over.step();
    over.F_ext[2] = 5.0;
    over.surface.distance = distance;
    for (int i = 0; i < 100; ++i) ASSERT_EQ(over.step().mode, ContactMode::contact) << distance;
  }
}

TEST(SurfaceContact, TheApproachRisesWithTheSurfaceThatTheTipHasLeft) {
  OverAPlane over;
  over.touch();
  over.arm.V_WE[2] = 0.1;
  for (int i = 0; i < 200; ++i) over.step();
  over.F_ext.setZero();
  over.surface.distance = 5e-3;
  while (over.step().mode == ContactMode::contact) {
  }
  Contact before = over.step();
  for (int i = 0; i < 20; ++i) {
    ASSERT_GT(before.rise, 0.05);
    const Contact now = over.step();
    ASSERT_NEAR(now.off_target - before.off_target, before.rise * over.settings.timing.dt, 1e-12);
    before = now;
  }
}

// Within what is known of a carrier's acceleration, its velocity is believed.
TEST(SurfaceContact, ASmallUnexplainedAccelerationOfTheCarrierIsItsOwn) {
  OverAPlane over;
  over.touch();
  for (int i = 0; i < 100; ++i) {
    over.carrier.v[2] += 0.09 * over.settings.timing.dt;
    over.arm.V_WE.head<3>() = over.carrier.v;
    ASSERT_NEAR(over.step().rise, 0.0, 1e-12);
  }
}

}  // namespace
}  // namespace impedraw
