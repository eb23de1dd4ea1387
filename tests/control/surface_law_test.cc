// The control law on the surface, step by step: error projections, normal force, tip friction and
// the transition at a switch.
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "arm_fixture.h"
#include "dense_algebra.h"

namespace impedraw {
namespace {

using namespace testing_arm;

// A tip on a plane of slope θ about y. The test uses only the arm's model and checks the commanded
// wrench.
struct OnSlope {
  ArmModel arm{kArm};
  ArmTerms terms{7};
  ImpedanceController controller;
  TipReference reference;
  SurfaceEstimate surface;
  Wrench F_ext = Wrench::Zero();

  // The arm does not react to its torque, which an observer would take for a disturbance.
  static ImpedanceSettings unobserved(ImpedanceSettings s) {
    s.observer.enabled = false;
    return s;
  }

  OnSlope(double slope, const ImpedanceSettings& s) : controller(unobserved(s), 7) {
    const Eigen::Vector3d n(-std::sin(slope), 0.0, std::cos(slope));
    const bool wall = slope > 1.0;
    JointVector upright(7);
    upright << 0.0, 0.3, 0.0, -1.8, 0.0, -0.6, 0.0;
    const IkResult ik = find_posture(arm, {{wall ? 0.74 : 0.6, 0.0, wall ? 0.45 : 0.2}, -n},
                                     wall ? upright : working_posture());
    EXPECT_TRUE(ik.reached);
    arm.compute(ik.q, JointVector::Zero(7), &terms);
    reference.p_WD = terms.X_WE.p;
    reference.n_WD = n;
    reference.pen_down = true;
    surface.status = SurfaceStatus::ok;
    surface.n_W = n;
    surface.distance = 0.0;
  }

  const ImpedanceTorque& settle() {  // in contact, at rest, after every transition
    F_ext.head<3>() = 5.0 * surface.n_W;
    const ImpedanceTorque* out = nullptr;
    for (int i = 0; i < 2000; ++i) out = &controller.step(terms, reference, surface, F_ext);
    return *out;
  }

  // The tip wrench equivalent to a term.
  Vector6 wrench(const ImpedanceTorque& out, TorqueTerm term) {
    OperationalSpace space;
    space.update(terms);
    return space.project_to_tip(out.terms.col(term));
  }
};

ImpedanceSettings natural_measured(const ArmModel& arm) {
  ImpedanceSettings s = shaped_settings(arm);
  s.inertia = InertiaShaping::natural;  // M_d = Λ: F_act is the desired force
  return s;
}

TEST(SurfaceLaw, PushesAlongTheNormalAndNowhereElse) {
  ArmModel arm(kArm);
  OnSlope on(0.5, natural_measured(arm));
  const ImpedanceTorque& out = on.settle();
  ASSERT_EQ(out.mode, ContactMode::contact);
  EXPECT_EQ(out.push, 5.0);
  Vector6 expected = Vector6::Zero();
  expected.head<3>() = -5.0 * on.surface.n_W;
  EXPECT_LT((on.wrench(out, kPush) - expected).norm(), 1e-9);
}

TEST(SurfaceLaw, LiftsTheErrorToFullStiffnessOnASlope) {
  ArmModel arm(kArm);
  const double slope = 0.7, shift = 1e-3;
  for (const ErrorProjection projection : {ErrorProjection::lifted, ErrorProjection::paper}) {
    ImpedanceSettings s = natural_measured(arm);
    s.surface.projection = projection;
    OnSlope on(slope, s);
    const Vector6 before = on.wrench(on.settle(), kImpedance);
    on.reference.p_WD.x() +=
        shift;  // up the slope as seen along z; along the slope it is shift/cos θ
    const Vector6 force = on.wrench(on.settle(), kImpedance) - before;
    const Eigen::Vector3d uphill(std::cos(slope), 0.0, std::sin(slope));
    const double expected =
        s.stiffness.linear.tangent * shift *
        (projection == ErrorProjection::lifted ? 1.0 / std::cos(slope) : std::cos(slope));
    EXPECT_NEAR(force.head<3>().dot(uphill), expected, 1e-6);
    EXPECT_NEAR(force.head<3>().dot(on.surface.n_W), 0.0, 1e-9) << "no stiffness along the normal";
  }
}

TEST(SurfaceLaw, TheHeightOfThePlanDoesNotMatterInContact) {
  ArmModel arm(kArm);
  OnSlope on(0.5, natural_measured(arm));
  const Vector6 before = on.wrench(on.settle(), kImpedance);
  on.reference.p_WD.z() += 0.01;
  EXPECT_LT((on.wrench(on.settle(), kImpedance) - before).norm(), 1e-9);
}

// A pen that slipped over an edge onto a wall was held by nothing along the wall: seen along z, it
// was still above its place.
TEST(SurfaceLaw, OnAWallThePlansHeightPullsThePenUp) {
  ArmModel arm(kArm);
  for (const double slope_deg : {75.0, 80.0, 85.0, 89.0}) {
    const double slope = slope_deg * std::numbers::pi / 180.0, up = 2e-3;
    const ImpedanceSettings s = natural_measured(arm);
    OnSlope on(slope, s);
    const Vector6 before = on.wrench(on.settle(), kImpedance);
    on.reference.p_WD.z() += up;
    const Vector6 force = on.wrench(on.settle(), kImpedance) - before;
    const Eigen::Vector3d uphill(std::cos(slope), 0.0, std::sin(slope));
    const double c = std::cos(slope), least = s.surface.min_axis_cosine;
    const double share = c < least ? 1.0 - std::pow(c / least, 2) : 0.0;
    EXPECT_NEAR(force.head<3>().dot(uphill),
                s.stiffness.linear.tangent * up * std::sin(slope) * share, 1e-6)
        << slope_deg;
    EXPECT_NEAR(force.head<3>().dot(on.surface.n_W), 0.0, 1e-9) << "no stiffness along the normal";
  }
}

TEST(SurfaceLaw, TheLiftIsContinuousWhereTheWallBegins) {
  ArmModel arm(kArm);
  const ImpedanceSettings s = natural_measured(arm);
  std::vector<Eigen::Vector3d> force;
  for (const double c :
       {s.surface.min_axis_cosine * (1.0 + 1e-6), s.surface.min_axis_cosine * (1.0 - 1e-6)}) {
    OnSlope on(std::acos(c), s);
    const Vector6 before = on.wrench(on.settle(), kImpedance);
    on.reference.p_WD += Eigen::Vector3d(1e-3, 5e-4, -1e-3);
    force.emplace_back((on.wrench(on.settle(), kImpedance) - before).head<3>());
  }
  EXPECT_GT(force[0].norm(), 1.0);
  EXPECT_LT((force[1] - force[0]).norm(), 1e-3 * force[0].norm());
}

TEST(SurfaceLaw, LeavesOutWhatTipFrictionExplainsAndNothingElse) {
  ArmModel arm(kArm);
  ImpedanceSettings s = natural_measured(arm);
  s.friction.normal_error_deg = 0.0;
  OnSlope on(0.3, s);
  on.settle();
  // Slide along y. The measured wrench contains friction along −y and a push along the other
  // tangent.
  JointVector v = on.terms.J.transpose() * inverse(on.terms.J * on.terms.J.transpose()) *
                  Vector6(0.05 * Vector6::Unit(1));
  on.arm.compute(on.terms.q, v, &on.terms);
  const Eigen::Vector3d n = on.surface.n_W, across = Eigen::Vector3d::UnitY().cross(n);
  const auto friction_term = [&](double along, double hand) {
    Wrench F = Wrench::Zero();
    F.head<3>() = 5.0 * n - along * Eigen::Vector3d::UnitY() + hand * across;
    return Vector6(on.wrench(on.controller.step(on.terms, on.reference, on.surface, F), kWrench));
  };
  // With M_d = Λ the wrench term is minus the excluded friction, so it cancels friction.
  const double limit = s.friction.coefficient * 5.0,
               smooth = 0.05 / std::hypot(0.05, s.friction.fade_speed);
  EXPECT_NEAR(friction_term(1.2, 0.0)[1], 1.2 * smooth * smooth, 1e-6);
  EXPECT_NEAR(friction_term(4.0, 0.0)[1], limit * smooth, 1e-6) << "no more than μ̂ f_n";
  EXPECT_NEAR(friction_term(-4.0, 0.0).norm(), 0.0, 1e-9)
      << "a force along the motion is no friction";
  EXPECT_NEAR(friction_term(0.0, 10.0).norm(), 0.0, 1e-9)
      << "a hand from the side is not friction: the pen gives way to it";
}

TEST(SurfaceLaw, AWrongNormalDoesNotPushThePenAside) {
  ArmModel arm(kArm);
  ImpedanceSettings s = natural_measured(arm);
  s.friction.coefficient = 0.0;
  s.friction.normal_error_deg = 20.0;
  OnSlope on(0.3, s);
  on.settle();
  const Eigen::Vector3d n = on.surface.n_W, along = Eigen::Vector3d::UnitY(),
                        across = along.cross(n);
  const auto cancelled = [&](double speed, double error_deg) {
    const JointVector v = on.terms.J.transpose() * inverse(on.terms.J * on.terms.J.transpose()) *
                          Vector6(speed * Vector6::Unit(1));
    on.arm.compute(on.terms.q, v, &on.terms);
    const double error = error_deg * std::numbers::pi / 180.0;
    Wrench F = Wrench::Zero();  // 5 N along n, from a surface whose normal is turned about y
    F.head<3>() = 5.0 * (n + std::tan(error) * across);
    return Eigen::Vector3d(
        on.wrench(on.controller.step(on.terms, on.reference, on.surface, F), kWrench).head<3>());
  };
  const double smooth = 0.05 / std::hypot(0.05, s.friction.fade_speed);
  // With M_d = Λ the wrench term is minus the force that the pen does not yield to.
  EXPECT_NEAR(cancelled(0.05, 10.0).dot(across), -5.0 * std::tan(0.17453293) * smooth, 1e-6);
  EXPECT_NEAR(cancelled(0.05, 40.0).dot(across), -5.0 * std::tan(0.34906585), 1e-6)
      << "no more than control.normal_error explains";
  EXPECT_NEAR(cancelled(0.05, 10.0).dot(along), 0.0, 1e-6);
  EXPECT_NEAR(cancelled(0.0, 10.0).norm(), 0.0, 1e-6)
      << "at rest it may be the spring's own pull, against friction";
}

TEST(SurfaceLaw, NoStepInTorqueAtASwitch) {
  ArmModel arm(kArm);
  for (const bool natural : {false, true}) {
    const ImpedanceSettings s = natural ? natural_measured(arm) : shaped_settings(arm);
    OnSlope on(0.4, s);
    on.reference.pen_down = false;
    on.reference.p_WD += 2e-4 * Eigen::Vector3d(1, 1, 1);
    on.surface.distance = 2e-4;
    JointVector last = on.controller.step(on.terms, on.reference, on.surface, on.F_ext).tau;
    ContactMode mode = ContactMode::free;
    int switches = 0;
    double largest = 0.0;
    for (int i = 0; i < 1200; ++i) {
      on.reference.pen_down = i > 100 && i < 900;
      // The tip's spring takes up the push as the pen sinks in and gives it back as it leaves.
      const double taken_up = std::clamp(0.02 * (i - 100), 0.0, 5.0);
      const double given_back = std::clamp(0.02 * (i - 900), 0.0, 5.0);
      on.F_ext.head<3>() = (taken_up - given_back) * on.surface.n_W;
      if (i >= 900) on.surface.distance = 1e-5 * (i - 900);
      const ImpedanceTorque& out = on.controller.step(on.terms, on.reference, on.surface, on.F_ext);
      const double jump = (out.tau - last).cwiseAbs().maxCoeff();
      switches += out.mode != mode;
      largest = std::max(largest, jump);
      mode = out.mode;
      last = out.tau;
    }
    EXPECT_EQ(switches, 4);
    // As measured: 5 N that fade in and out over the switch time of 40 ms, at up to 0.8 m; shaped,
    // times Λ/M_d.
    const double measured = natural ? 0.191 : 0.606 / s.shaped_inertia.linear.normal;
    EXPECT_LT(largest, 1.3 * measured);
  }
}

// On a duck's tail, thin as a sheet, the estimate turned by 165° and back, and the pen hammered
// there for a second; or the pen was lifted as from a lost surface, and a stroke was not drawn.
TEST(SurfaceLaw, TheOtherSideOfAThinBodyIsFollowedAsThisOne) {
  ArmModel arm(kArm);
  OnSlope on(0.4, shaped_settings(arm));
  on.settle();
  const Eigen::Vector3d n = on.controller.step(on.terms, on.reference, on.surface, on.F_ext).n_WD;
  on.surface.n_W = -on.surface.n_W;
  on.surface.distance = -on.surface.distance;
  for (int i = 0; i < 400; ++i) {
    const ImpedanceTorque& out = on.controller.step(on.terms, on.reference, on.surface, on.F_ext);
    ASSERT_FALSE(out.status.surface_lost);
    ASSERT_EQ(out.mode, ContactMode::contact);
    ASSERT_LT((out.n_WD - n).norm(), 1e-6);
  }
}

TEST(SurfaceLaw, ALostSurfaceKeepsTheLastNormalAndThenRetreats) {
  ArmModel arm(kArm);
  OnSlope on(0.4, shaped_settings(arm));
  on.settle();
  on.surface.status = SurfaceStatus::too_few;
  on.surface.n_W = Eigen::Vector3d::UnitX();  // wrong, and must not be used
  const ImpedanceTorque* out = &on.controller.step(on.terms, on.reference, on.surface, on.F_ext);
  EXPECT_TRUE(out->status.surface_lost);
  EXPECT_EQ(out->mode, ContactMode::contact);
  EXPECT_LT((out->n_WD - on.reference.n_WD).norm(), 1e-6);
  for (int i = 0; i < 400; ++i)
    out = &on.controller.step(on.terms, on.reference, on.surface, on.F_ext);
  EXPECT_EQ(out->mode, ContactMode::retreat);
  EXPECT_EQ(out->push, 0.0);
}

}  // namespace
}  // namespace impedraw
