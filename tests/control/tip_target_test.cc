// The desired motion of the tip against finite differences of paths whose shape is known.
#include "impedraw/control/tip_target.h"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "any_arm.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
using testing_arm::AnyArm;

// A smooth path, with its derivatives.
struct Swing {
  Vector3d amplitude, rate, phase;
  Vector3d at(double t, int derivative = 0) const {
    const Eigen::Array3d x = rate.array() * t + phase.array();
    const Eigen::Array3d scale = amplitude.array() * rate.array().pow(derivative);
    if (derivative == 1) return scale * x.cos();
    return (derivative == 0 ? 1.0 : -1.0) * (scale * x.sin()).matrix();
  }
};
Swing swing(AnyArm& any, double size) {
  return {any.vector(size), any.vector(3.0), any.vector(3.0)};
}

// A plane in K, which moves and turns. The plan leaves the plane, along the axis along which it is
// projected: the tip follows its shadow.
struct MovingPlane {
  Swing origin, shadow;
  Vector3d axis, n_K, z_K, off_K;
  double turn_rate, leaving, leaving_faster;

  Pose X_WK(double t) const {
    return {origin.at(t),
            Eigen::AngleAxisd(std::sin(turn_rate * t + 0.4), axis).toRotationMatrix()};
  }
  FrameMotion frame(double t) const {
    FrameMotion m;
    m.X_WK = X_WK(t);
    m.v = origin.at(t, 1);
    m.a = origin.at(t, 2);
    m.w = turn_rate * std::cos(turn_rate * t + 0.4) * axis;
    m.alpha = -turn_rate * turn_rate * std::sin(turn_rate * t + 0.4) * axis;
    return m;
  }
  Vector3d in_plane(const Vector3d& x) const { return x - n_K * n_K.dot(x); }
  Vector3d shadow_W(double t) const { return X_WK(t) * in_plane(shadow.at(t)); }
  // In W, at t = 0.
  TipReference plan() const {
    TipReference in_K;
    in_K.p_WD = in_plane(shadow.at(0.0));
    in_K.v_WD = in_plane(shadow.at(0.0, 1)) + leaving * off_K;
    in_K.a_WD = in_plane(shadow.at(0.0, 2)) + leaving_faster * off_K;
    in_K.n_WD = n_K;
    return carried(in_K, frame(0.0));
  }
};

MovingPlane moving_plane(AnyArm& any, bool lifted) {
  MovingPlane plane{swing(any, 0.2),
                    swing(any, 0.1),
                    any.direction(),
                    any.direction(),
                    {},
                    {},
                    any.number(0.5, 2.0),
                    0.05,
                    0.4};
  plane.z_K = (plane.n_K + 0.4 * any.direction()).normalized();
  plane.off_K = lifted ? plane.z_K : plane.n_K;
  return plane;
}

// In contact, with a tip that is a rigid point.
ImpedanceSettings of_a_point(ErrorProjection projection, const Vector3d& z) {
  ImpedanceSettings s;
  s.tip = {0.0, 0.0};
  s.surface.projection = projection;
  s.surface.drawing_axis_W = z;
  return s;
}

TEST(TipTarget, OnAMovingCanvasIsTheSecondDerivativeOfThePathThere) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    for (const ErrorProjection projection : {ErrorProjection::lifted, ErrorProjection::paper}) {
      SCOPED_TRACE(seed);
      AnyArm any(seed);
      const MovingPlane plane = moving_plane(any, projection == ErrorProjection::lifted);
      const ArmTerms arm = any.terms();
      const FrameMotion frame = plane.frame(0.0);
      const TipReference plan = plane.plan();
      Contact contact;
      contact.mode = ContactMode::contact;
      contact.n = contact.n_C = contact.n_T = frame.X_WK.R * plane.n_K;
      contact.w_T = frame.w - contact.n * contact.n.dot(frame.w);
      const TipTarget d = target_on_surface({arm, plan, {}, Wrench::Zero(), false, &frame}, contact,
                                            0.0, of_a_point(projection, plane.z_K));
      constexpr double h = 1e-4;
      const Vector3d before = plane.shadow_W(-h), now = plane.shadow_W(0.0),
                     after = plane.shadow_W(h);
      EXPECT_LT((d.V.head<3>() - (after - before) / (2 * h)).norm(), 1e-6);
      EXPECT_LT((d.Vdot.head<3>() - (after - 2.0 * now + before) / (h * h)).norm(), 1e-5);
      EXPECT_LT((d.V.tail<3>() - contact.w_T).norm(), 1e-12) << "the axis turns with the plane";
    }
  }
}

TEST(TipTarget, ASurfaceThatRisesTakesTheTipWithIt) {
  AnyArm any(1);
  const MovingPlane plane = moving_plane(any, true);
  const ArmTerms arm = any.terms();
  const FrameMotion frame = plane.frame(0.0);
  const TipReference plan = plane.plan();
  Contact contact;
  contact.mode = ContactMode::contact;
  contact.n = contact.n_C = frame.X_WK.R * plane.n_K;
  const auto V = [&](double rise) {
    contact.rise = rise;
    return target_on_surface({arm, plan, {}, Wrench::Zero(), false, &frame}, contact, 0.0,
                             of_a_point(ErrorProjection::lifted, plane.z_K))
        .V;
  };
  EXPECT_LT(((V(0.03) - V(0.0)).head<3>() - 0.03 * contact.n).norm(), 1e-12);
}

// The ball of radius r, flattened by `give`, leaves its ink under its centre.
TEST(TipTarget, TheInkOfALeaningSoftTipLiesOnThePlan) {
  AnyArm any(2);
  for (int i = 0; i < 20; ++i) {
    const ArmTerms arm = any.terms();
    TipReference plan;
    plan.p_WD = any.vector(0.3);
    Contact contact;
    contact.mode = ContactMode::contact;
    contact.n = any.direction();
    contact.n_C = (contact.n + 0.2 * any.direction()).normalized();
    ImpedanceSettings s;
    const double r = 1.5e-3, push = 4.0, stiffness = 8e3;
    s.tip = {r, stiffness};
    const TipTarget d =
        target_on_surface({arm, plan, {}, Wrench::Zero(), false, nullptr}, contact, push, s);
    const Vector3d centre = d.p_WD - r * arm.X_WE.R.col(2);
    const Vector3d ink = centre - (r - push / stiffness) * contact.n_C;
    EXPECT_LT((ink - plan.p_WD).norm(), 1e-12);
  }
}

TEST(TipTarget, InContactNothingPullsAlongTheNormalAndInApproachTheTipSinks) {
  AnyArm any(3);
  for (int i = 0; i < 20; ++i) {
    const ArmTerms arm = any.terms();
    TipReference plan;
    plan.p_WD = arm.X_WE.p + any.vector(0.01);
    plan.v_WD = any.vector(0.1);
    Contact contact;
    contact.n = contact.n_C = contact.n_T = any.direction();
    ImpedanceSettings s = of_a_point(ErrorProjection::lifted, contact.n);
    s.surface.drawing_axis_W = (contact.n + 0.5 * any.direction()).normalized();
    contact.mode = ContactMode::contact;
    const StepInput in{arm, plan, {}, Wrench::Zero(), false, nullptr};
    TipTarget d = target_on_surface(in, contact, 0.0, s);
    EXPECT_NEAR(contact.n.dot(d.Ke.head<3>()), 0.0, 1e-9);
    EXPECT_NEAR(contact.n.dot(d.V.head<3>()), 0.0, 1e-12);
    contact.mode = ContactMode::approach;
    contact.sinking = 0.02;
    contact.off_target = -1e-3;
    d = target_on_surface(in, contact, 0.0, s);
    EXPECT_NEAR(contact.n.dot(d.V.head<3>()), -0.02, 1e-12);
    EXPECT_NEAR(contact.n.dot(d.Ke.head<3>()), -1e-3 * s.stiffness.linear.normal, 1e-9);
  }
}

TEST(TipTarget, OnThePlanThePoseIsFollowedAndARetreatGoesOut) {
  AnyArm any(4);
  const ArmTerms arm = any.terms();
  TipReference plan;
  plan.p_WD = arm.X_WE.p + any.vector(0.01);
  plan.n_WD = any.direction();
  plan.v_WD = any.vector(0.1);
  plan.a_WD = any.vector(0.1);
  const ImpedanceSettings s;
  Contact contact;
  const StepInput in{arm, plan, {}, Wrench::Zero(), false, nullptr};
  TipTarget d = target_on_plan(in, contact, s);
  const Vector3d e = plan.p_WD - arm.X_WE.p, along = plan.n_WD * plan.n_WD.dot(e);
  EXPECT_LT((d.Ke.head<3>() - s.stiffness.linear.tangent * (e - along) -
             s.stiffness.linear.normal * along)
                .norm(),
            1e-9);
  EXPECT_EQ(d.V.head<3>(), plan.v_WD);
  EXPECT_EQ(d.Vdot.head<3>(), plan.a_WD);
  EXPECT_EQ(d.axis_WD, plan.n_WD);
  contact.mode = ContactMode::retreat;
  d = target_on_plan(in, contact, s);
  EXPECT_LT((d.p_WD - plan.p_WD - s.approach.retreat_height * plan.n_WD).norm(), 1e-12);
}

// On a ball, whose normal turns as the tip goes, by finite differences of the plan's shadow there.
TEST(TipTarget, OnACurvedSurfaceIsTheSecondDerivativeOfThePlansShadow) {
  AnyArm any(5);
  constexpr double kRadius = 0.3, h = 1e-4;
  for (int i = 0; i < 20; ++i) {
    const Swing path = swing(any, 0.05);
    const Vector3d z = any.direction();
    const auto shadow = [&](double t) {
      const Vector3d p = path.at(t), flat = p - z * z.dot(p);
      return Vector3d(flat + z * std::sqrt(kRadius * kRadius - flat.squaredNorm()));
    };
    const Vector3d before = shadow(-h), now = shadow(0.0), after = shadow(h);
    TipReference plan;
    plan.p_WD = path.at(0.0);
    plan.v_WD = path.at(0.0, 1);
    plan.a_WD = path.at(0.0, 2);
    Contact contact;
    contact.mode = ContactMode::contact;
    contact.n = contact.n_C = contact.n_T = now / kRadius;
    contact.w_T = now.cross(after - before) / (2 * h * kRadius * kRadius);
    const TipTarget d = target_on_surface({any.terms(), plan, {}, Wrench::Zero(), false, nullptr},
                                          contact, 0.0, of_a_point(ErrorProjection::lifted, z));
    EXPECT_LT((d.V.head<3>() - (after - before) / (2 * h)).norm(), 1e-6);
    EXPECT_LT((d.Vdot.head<3>() - (after - 2.0 * now + before) / (h * h)).norm(), 1e-5);
  }
}

TEST(TipTarget, TheRestOfTheMotionAlongTheNormalAndThePapersError) {
  AnyArm any(6);
  const ArmTerms arm = any.terms();
  TipReference plan;
  plan.p_WD = arm.X_WE.p + any.vector(0.01);
  const Vector3d n = plan.n_WD, e = plan.p_WD - arm.X_WE.p;
  Contact contact;
  const StepInput in{arm, plan, {}, Wrench::Zero(), false, nullptr};
  contact.rise = 0.03;
  EXPECT_LT((target_on_plan(in, contact, {}).V.head<3>() - 0.03 * n).norm(), 1e-12);
  contact.mode = ContactMode::approach;
  contact.sinking = 0.02;
  const Vector3d along_surface = Vector3d(1.0, 0.0, 0.1).normalized();
  TipTarget d =
      target_on_surface(in, contact, 0.0, of_a_point(ErrorProjection::lifted, along_surface));
  EXPECT_LT((d.V.head<3>() + 0.02 * n).norm(), 1e-12) << "on a wall along the axis";
  contact.mode = ContactMode::contact;
  contact.force_rate = 4.0;
  ImpedanceSettings s = of_a_point(ErrorProjection::paper, Vector3d(0.0, 0.6, 0.8));
  s.tip.stiffness = 5e3;
  d = target_on_surface(in, contact, 0.0, s);
  EXPECT_LT((d.V.head<3>() + 4.0 / 5e3 * n).norm(), 1e-12) << "a swelling force goes deeper";
  const Vector3d z = s.surface.drawing_axis_W, seen = z.cross(e).cross(z);
  EXPECT_LT((d.Ke.head<3>() - s.stiffness.linear.tangent * Vector3d(seen.x(), seen.y(), 0)).norm(),
            1e-9);
}

}  // namespace
}  // namespace impedraw
