// A line's contact against closed forms: of a knife's balance of work, and of a line that turns.
#include "impedraw/simulation/blade_law.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "impedraw/canvas/built_in.h"
#include "impedraw/simulation/pad_contact.h"
#include "simulation/worlds.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

constexpr double kForce = 2.0;  // [N]

// x_E points along `heading` from x; z_E down; pressed `depth` deeper than under the force.
PadLoad load(const PadSettings& face, double heading, const Vector6& V, int steps,
             double depth = 0.0) {
  PlaneSettings settings;
  settings.centre = {0.0, 0.0, 0.0};
  const Canvas plane(make_plane(settings));
  const Eigen::Matrix3d R =
      (Eigen::AngleAxisd(heading, Vector3d::UnitZ()) * Eigen::AngleAxisd(pi, Vector3d::UnitX()))
          .toRotationMatrix();
  PadContact contact(face);
  for (int i = 1; i < steps; ++i) contact.press(plane, {{0.01, 0.02, -depth}, R}, V, 1e-3);
  return contact.press(plane, {{0.01, 0.02, -depth}, R}, V, 1e-3);
}

Vector6 sliding(double angle) {
  Vector6 V = Vector6::Zero();
  V.head<2>() = 0.05 * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  return V;
}

// Drag R d, down R d cot α, aside R (c + d), with c = d cot α.
TEST(Blade, DoesTheWorkOfFracture) {
  for (const double degrees : {30.0, 45.0, 70.0}) {
    BladeSettings blade;
    blade.angle = degrees * pi / 180.0;
    const PadSettings edge = blade_edge(blade, 0.0, kForce);
    const double d = kForce * std::tan(blade.angle) / blade.toughness,
                 c = d / std::tan(blade.angle);
    EXPECT_NEAR(edge.rest, d, 1e-12);
    EXPECT_NEAR(edge.area(), c, 1e-12);
    for (const double heading : {0.0, 0.7, -2.0}) {
      const PadLoad along = load(edge, heading, sliding(heading), 400);
      EXPECT_NEAR(along.f.z(), kForce, 1e-6 * kForce);
      const Eigen::Vector2d way = sliding(heading).head<2>() / 0.05;
      EXPECT_NEAR((along.f.head<2>() + blade.toughness * d * way).norm(), 0.0, 1e-6)
          << degrees << " " << heading;
      const PadLoad across = load(edge, heading, sliding(heading + pi / 2.0), 400);
      EXPECT_NEAR(across.f.head<2>().norm(), blade.toughness * (c + d), 1e-6);
      EXPECT_NEAR(across.f.head<2>().dot(sliding(heading).head<2>()), 0.0, 1e-6);
    }
    // The work is linear in the slip: at a slant both parts are as large as alone.
    const PadLoad slant = load(edge, 0.0, sliding(0.3), 2000);
    EXPECT_NEAR(slant.f.x(), -blade.toughness * d, 1e-6);
    EXPECT_NEAR(slant.f.y(), -blade.toughness * (c + d), 1e-6);
  }
}

TEST(Blade, SinksByTheForce) {
  const BladeSettings blade;
  const PadSettings edge = blade_edge(blade, 0.0, kForce);
  for (const double deeper : {-1e-4, 1e-4}) {
    const PadLoad at = load(edge, 0.4, Vector6::Zero(), 1, deeper);
    EXPECT_NEAR(at.f.z(), blade.toughness / std::tan(blade.angle) * (edge.rest + deeper), 1e-6);
  }
}

TEST(Blade, TurnsOnTheSpotAgainstItsHalfLength) {
  const PadSettings edge = blade_edge({}, 2e-3, kForce);
  EXPECT_EQ(edge.radius, 2e-3);
  EXPECT_GE(edge.thickness, 5e-3);
  Vector6 V = Vector6::Zero();
  V[5] = 20.0;
  const double M = edge.friction_across * kForce * edge.radius / 2.0;
  PlaneSettings settings;
  settings.centre = {0.0, 0.0, 0.0};
  const Canvas plane(make_plane(settings));
  PadContact contact(edge);
  double heading = 0.0, moment = 0.0;
  for (int i = 0; i < 3000; ++i, heading += 20e-3) {
    const Eigen::Matrix3d R =
        (Eigen::AngleAxisd(heading, Vector3d::UnitZ()) * Eigen::AngleAxisd(pi, Vector3d::UnitX()))
            .toRotationMatrix();
    moment = contact.press(plane, {Vector3d::Zero(), R}, V, 1e-3).m.z();
  }
  EXPECT_NEAR(moment, -M, 0.03 * M);
}

TEST(Roller, RollsAlongAndSticksAcross) {
  PadSettings pad;
  const PadSettings line = roller_line(pad, 0.0, kForce);
  EXPECT_NEAR(load(line, 0.5, sliding(0.5), 2000).f.head<2>().norm(), line.friction * kForce, 1e-6);
  EXPECT_NEAR(load(line, 0.5, sliding(0.5 + pi / 2.0), 4000).f.head<2>().norm(),
              pad.friction * kForce, 1e-6);
}

// Free sliding in MuJoCo: the world presses a blade as hard, and drags it as much, as its law says.
TEST(Blade, InTheWorldIsItsLaw) {
  const Canvas canvas = testing_worlds::plane_under(Vector3d::Zero(), 0.0);
  WorldSettings settings;
  settings.gravity = 0.0;
  settings.pad = blade_edge({}, 0.0, kForce);
  World world(testing_worlds::kSlider, &canvas, settings);
  const Pose X = world.state().X_WE;
  ASSERT_NEAR(std::abs(X.R.col(2).z()), 1.0, 1e-9);
  JointVector q = JointVector::Zero(3), v = JointVector::Zero(3);
  const Vector3d x = X.R.col(0);
  v.head<2>() = 0.02 * x.head<2>();
  world.set_state(q, v);
  Vector3d f = Vector3d::Zero();
  for (int i = 0; i < 2000; ++i) {
    JointVector tau(3);  // holds the way and its speed
    for (int j = 0; j < 2; ++j) {
      const double way = v[j] * world.state().time;
      tau[j] = 5e3 * (way - world.state().q[j]) + 200.0 * (v[j] - world.state().v[j]);
    }
    tau[2] = -kForce;
    const TipContact& contact = world.step(tau, Vector3d::Zero());
    if (i >= 1500) f += contact.f_W / 500.0;
  }
  EXPECT_NEAR(f.z(), kForce, 0.01 * kForce);
  EXPECT_NEAR(f.dot(x), -settings.pad->friction * kForce, 0.02 * kForce);
  EXPECT_NEAR(world.state().q[2], 0.0, 2e-5) << "E lies on the surface under the force";
}

}  // namespace
}  // namespace impedraw
