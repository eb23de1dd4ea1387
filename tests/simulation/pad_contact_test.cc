// The pad's contact against closed forms of a rigid disc on a bed of springs.
#include "impedraw/simulation/pad_contact.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "impedraw/canvas/built_in.h"

namespace impedraw {
namespace {

Canvas plane() {
  PlaneSettings settings;
  settings.centre = {0.0, 0.0, 0.0};
  return Canvas(make_plane(settings));
}

// The pad looks down; its face is pressed by `depth` and tilted about x.
Pose pressed(double depth, double tilt = 0.0) {
  const Eigen::AngleAxisd down(std::numbers::pi + tilt, Eigen::Vector3d::UnitX());
  return {Eigen::Vector3d(0.003, -0.002, -depth), down.toRotationMatrix()};
}

PadLoad load(const Pose& X, const Vector6& V = Vector6::Zero(), int steps = 1) {
  PadContact pad{PadSettings()};
  const Canvas canvas = plane();
  for (int i = 1; i < steps; ++i) pad.press(canvas, X, V, 1e-3);
  return pad.press(canvas, X, V, 1e-3);
}

TEST(Pad, ForceOfADiscOnSprings) {
  const PadSettings s;
  const PadLoad at = load(pressed(1.2e-3));
  EXPECT_NEAR(at.f.z(), s.stiffness * s.area() * 1.2e-3, 1e-9);
  EXPECT_LT(at.f.head<2>().norm() + at.m.norm(), 1e-9);
  EXPECT_FALSE(load(pressed(-1e-4)).touching);
}

// Pressed deeper than its foam is thick, it does not fall through.
TEST(Pad, BearsDeeperThanItsFoam) {
  const PadSettings s;
  for (const double depth : {0.9, 1.1, 1.5}) {
    const PadLoad at = load(pressed(depth * s.thickness));
    EXPECT_NEAR(at.f.z(), s.stiffness * s.area() * depth * s.thickness, 1e-6) << depth;
  }
}

TEST(Pad, MomentOfATiltedDisc) {
  const PadSettings s;
  const double tilt = 0.01, inertia = std::numbers::pi / 4.0 * std::pow(s.radius, 4);
  const PadLoad at = load(pressed(1.2e-3, tilt));
  EXPECT_NEAR(at.f.z(), s.stiffness * s.area() * 1.2e-3, 2e-4 * at.f.z());
  // About the point where the pad's axis meets the plane.
  const Eigen::Vector3d axis = pressed(1.2e-3, tilt).R.col(2);
  const double moment = (at.m - (1.2e-3 / axis.z() * axis).cross(at.f)).x();
  EXPECT_NEAR(std::abs(moment), s.stiffness * inertia * tilt, 2e-3 * s.stiffness * inertia * tilt);
  // It turns the pad back onto the plane.
  EXPECT_LT(moment * tilt, 0.0);
}

TEST(Pad, SlidingAndTurningFriction) {
  const PadSettings s;
  const double force = s.stiffness * s.area() * 1.2e-3;
  Vector6 V = Vector6::Zero();
  V.head<2>() << 0.06, 0.08;
  const PadLoad slides = load(pressed(1.2e-3), V, 200);
  EXPECT_NEAR(slides.f.x(), -0.6 * s.friction * force, 1e-6);
  EXPECT_NEAR(slides.f.y(), -0.8 * s.friction * force, 1e-6);
  Vector6 W = Vector6::Zero();
  W[5] = 20.0;  // the centre of E lies on the axis
  const PadLoad turns = load(pressed(1.2e-3), W, 2000);
  EXPECT_NEAR(turns.m.z(), -2.0 / 3.0 * s.friction * force * s.radius,
              0.02 * s.friction * force * s.radius);
}

// Joints turn the disc onto the plane, each about its own axis alone, and pass no moment on.
TEST(Pad, TurnsAboutItsJoints) {
  const Canvas canvas = plane();
  for (const int joints : {1, 2}) {
    PadSettings s;
    s.joints = joints;
    s.friction = 0.0;  // it would hold the disc before it is level
    for (const bool about_x : {true, false}) {
      PadContact pad(s);
      const double tilt = 0.05, inertia = std::numbers::pi / 4.0 * std::pow(s.radius, 4);
      Pose X = pressed(1.2e-3);
      const Eigen::Vector3d axis = about_x ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
      X.R = X.R * Eigen::AngleAxisd(tilt, axis).toRotationMatrix();
      PadLoad at;
      for (int i = 0; i < 500; ++i) at = pad.press(canvas, X, Vector6::Zero(), 1e-3);
      // About the joints' centre, in the middle of the disc.
      const Eigen::Vector3d centre(0.0, 0.0, s.rest - s.thickness);
      const double moment = (X.R.transpose() * (at.m - (X.R * centre).cross(at.f))).dot(axis);
      const bool turns = about_x || joints == 2;
      EXPECT_NEAR(pad.tilt()[about_x ? 0 : 1], turns ? -tilt : 0.0, 1e-4) << joints << about_x;
      // The foam's moment, less that of the force, which is not through the centre.
      const double stiff =
          s.stiffness * inertia - s.stiffness * s.area() * 1.2e-3 * (s.thickness - 1.2e-3);
      EXPECT_NEAR(std::abs(moment), turns ? 0.0 : stiff * tilt, 0.02 * stiff * tilt)
          << joints << about_x;
      EXPECT_NEAR(pad.tilt()[about_x ? 1 : 0], 0.0, 1e-4);
    }
  }
}

// The foam of a large disc damps its turning more than the joints do.
TEST(Pad, ALargeDiscComesToRestOnItsJoints) {
  const Canvas canvas = plane();
  for (const double radius : {0.015, 0.025, 0.05}) {
    PadSettings s;
    s.joints = 2;
    s.radius = radius;
    s.friction = 0.0;  // it would hold the disc before it is level
    PadContact pad(s);
    Pose X = pressed(1.2e-3);
    X.R = X.R * Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitX()).toRotationMatrix();
    for (int i = 0; i < 500; ++i) pad.press(canvas, X, Vector6::Zero(), 1e-3);
    EXPECT_NEAR(pad.tilt().x(), -0.02, 2e-3) << radius;
    const double at_rest = pad.tilt().x();
    pad.press(canvas, X, Vector6::Zero(), 1e-3);
    EXPECT_NEAR(pad.tilt().x(), at_rest, 1e-5) << radius;
    // Lifted while it turns, it turns no further.
    X.R = X.R * Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitX()).toRotationMatrix();
    pad.press(canvas, X, Vector6::Zero(), 1e-3);
    const double turning = pad.tilt().x();
    EXPECT_NE(turning, at_rest);
    X.p.z() += 0.05;
    pad.press(canvas, X, Vector6::Zero(), 1e-3);
    EXPECT_EQ(pad.tilt().x(), turning) << radius;
  }
}

// A disc that slides leans on its leading edge: its moment balances that of the friction.
TEST(Pad, LeansOnItsJointsAsItSlides) {
  const Canvas canvas = plane();
  for (const double pivot : {-0.009, -0.007}) {
    PadSettings s;
    s.joints = 2;
    s.pivot = pivot;
    const double depth = 1.5e-3, force = s.stiffness * s.area() * depth,
                 lever = s.thickness - depth + pivot,
                 stiffness = s.stiffness * std::numbers::pi / 4.0 * std::pow(s.radius, 4);
    PadContact pad(s);
    Vector6 V = Vector6::Zero();
    V.head<2>() << 0.1, 0.0;
    PadLoad at;
    for (int i = 0; i < 1000; ++i) at = pad.press(canvas, pressed(depth), V, 1e-3);
    const double lean = s.friction * force * lever / stiffness;
    EXPECT_NEAR(pad.tilt().norm(), std::abs(lean), 0.05 * std::abs(lean) + 1e-4) << pivot;
    // Its pressure is greater ahead: E looks down, its x axis is the world's.
    EXPECT_GT((at.centre - pressed(depth).p).x() * lever, 0.0) << pivot;
    EXPECT_NEAR((at.centre - pressed(depth).p).x(), s.friction * lever,
                0.1 * s.friction * std::abs(lever));
  }
}

TEST(Pad, PassesAMomentOnAtTheEndOfItsJoints) {
  const Canvas canvas = plane();
  PadSettings s;
  s.joints = 2;
  s.friction = 0.0;
  PadContact pad(s);
  const Pose X = pressed(1.5e-3, 0.45);
  PadLoad at;
  for (int i = 0; i < 500; ++i) at = pad.press(canvas, X, Vector6::Zero(), 1e-3);
  EXPECT_NEAR(pad.tilt().x(), -PadContact::kJointEnd, 1e-9);
  EXPECT_GT(std::abs((X.R.transpose() * at.m).x()), 1e-3);
  pad.reset();
  EXPECT_EQ(pad.tilt().norm(), 0.0);
}

TEST(Pad, SticksByItsShear) {
  const PadSettings s;
  Vector6 V = Vector6::Zero();
  V[0] = 1e-3;
  const PadLoad sticks = load(pressed(1.2e-3), V, 50);
  EXPECT_NEAR(sticks.f.x(), -0.5 * s.stiffness * s.area() * 50e-6, 1e-9);
}

// Pressed at 20 mm/s the foam resists more, along the normal alone.
TEST(Pad, DampsWhatPressesIt) {
  PadSettings s;
  s.damping = 0.01 * s.stiffness;
  PadContact pad(s);
  Vector6 V = Vector6::Zero();
  V[2] = -0.02;
  const PadLoad at = pad.press(plane(), pressed(1.2e-3), V, 1e-3);
  EXPECT_NEAR(at.f.z(), s.stiffness * s.area() * (1.2e-3 + 0.01 * 0.02), 1e-9);
  EXPECT_NEAR(at.n.z(), 1.0, 1e-12);
}

// The middle of a line lies `trail` behind E, and both of its halves bear alike.
TEST(Pad, ALineTrailsBehind) {
  PadSettings s;
  s.face = PadFace::edge;
  s.trail = 4e-3;
  const Pose X = pressed(1.2e-3);
  const PadLoad at = PadContact(s).press(plane(), X, Vector6::Zero(), 1e-3);
  EXPECT_LT((at.centre - X.p + s.trail * X.R.col(0)).head<2>().norm(), 1e-9);
}

// Drake's hydroelastic contact of the same foam, by tests/foreign/drake/pad.py (Drake 1.51.1): the
// disc on a plane, partly lifted at 0.2 rad and 1 mm, and a ball that dents it. Drake's ball has
// facets: its force is 2 % less than k π d² (R − d/3), the sphere's.
TEST(Pad, AgreesWithDrakesHydroelasticContact) {
  const struct {
    double depth, tilt, force, moment;
  } discs[] = {{1e-3, 0.0, 1.41269, 0.0},         {1e-3, 0.02, 1.41240, 0.001588},
               {1e-3, 0.05, 1.41092, 0.003969},   {1e-3, 0.2, 1.71403, 0.012134},
               {2e-3, 0.0, 2.82537, 0.0},         {2e-3, 0.02, 2.82481, 0.001588},
               {2e-3, 0.05, 2.82184, 0.003969},   {2e-3, 0.2, 2.82814, 0.014997},
               {3.5e-3, 0.0, 4.94440, 0.0},       {3.5e-3, 0.02, 4.94341, 0.001588},
               {3.5e-3, 0.05, 4.93822, 0.003969}, {3.5e-3, 0.2, 4.84584, 0.015775}};
  for (const auto& disc : discs) {
    SCOPED_TRACE(testing::Message() << disc.depth << " m, " << disc.tilt << " rad");
    const PadLoad at = load(pressed(disc.depth, disc.tilt));
    // Drake's springs lie along the plane's normal and push along the disc's, ours the other way
    // round: its vertical force is cos² of ours. The moment is about where the axis meets the
    // plane.
    const double cos2 = std::pow(std::cos(disc.tilt), 2);
    EXPECT_NEAR(cos2 * at.f.norm(), disc.force, 0.01 * disc.force);
    const Eigen::Vector3d axis = pressed(disc.depth, disc.tilt).R.col(2);
    const double moment = (at.m - (disc.depth / axis.z() * axis).cross(at.f)).x();
    EXPECT_NEAR(cos2 * std::abs(moment), disc.moment, 0.01 * disc.moment + 1e-6);
  }
  CapSettings ball{0.05, {0.003, -0.002, -0.05}, 0.03, 5e-4};
  PadContact pad{PadSettings()};
  const PadLoad at = pad.press(Canvas(make_dome(ball)), pressed(2e-3), Vector6::Zero(), 1e-3);
  EXPECT_NEAR(at.f.z(), 1.21453, 0.02 * 1.21453);
  EXPECT_NEAR(at.f.z(), 2e6 * std::numbers::pi * 4e-6 * (0.05 - 2e-3 / 3.0), 0.04 * at.f.z());
}

}  // namespace
}  // namespace impedraw
