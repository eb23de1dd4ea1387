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

TEST(Pad, SticksByItsShear) {
  const PadSettings s;
  Vector6 V = Vector6::Zero();
  V[0] = 1e-3;
  const PadLoad sticks = load(pressed(1.2e-3), V, 50);
  EXPECT_NEAR(sticks.f.x(), -0.5 * s.stiffness * s.area() * 50e-6, 1e-9);
}

// Drake's hydroelastic contact of the same foam, by tests/foreign/drake/pad.py (Drake 1.51.1): the
// disc on a plane, partly lifted at 0.2 rad, and a ball pressed into a wide pad. Its ball has
// facets, which make the force 1 to 6 % less than that of the sphere, more where the dent is small.
TEST(Pad, AgreesWithDrakesHydroelasticContact) {
  const struct {
    double depth, tilt, force, moment;
  } discs[] = {{1e-3, 0.0, 1.41269, 0.0},        {1e-3, 0.02, 1.41297, 0.001507},
               {1e-3, 0.05, 1.41445, 0.003770},  {1e-3, 0.2, 1.78446, 0.012119},
               {2e-3, 0.0, 2.82537, 0.0},        {2e-3, 0.02, 2.82594, 0.001556},
               {2e-3, 0.05, 2.82891, 0.003894},  {2e-3, 0.2, 2.94436, 0.015356},
               {3.5e-3, 0.0, 4.94440, 0.0},      {3.5e-3, 0.02, 4.94539, 0.001693},
               {3.5e-3, 0.05, 4.95059, 0.004237}, {3.5e-3, 0.2, 5.04497, 0.017283}};
  for (const auto& disc : discs) {
    SCOPED_TRACE(testing::Message() << disc.depth << " m, " << disc.tilt << " rad");
    const PadLoad at = load(pressed(disc.depth, disc.tilt));
    const double within = disc.tilt > 0.1 ? 0.03 : 0.005;
    EXPECT_NEAR(at.f.norm(), disc.force, within * disc.force);
    EXPECT_NEAR(std::abs(at.m.x()), disc.moment, 0.03 * disc.moment + 1e-6);
  }
}

}  // namespace
}  // namespace impedraw
