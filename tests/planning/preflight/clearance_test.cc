// Distances of the arm's bodies to meshes against closed forms and brute force.
#include "impedraw/planning/preflight/clearance.h"

#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "arm_on_surface.h"
#include "impedraw/canvas/built_in.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr double kTip = 5e-3;  // unchecked length of the pen above its tip [m]

JointVector random_posture(std::mt19937& rng, const ArmLimits& limits) {
  std::uniform_real_distribution<double> share(0.1, 0.9);
  JointVector q(limits.lower.size());
  for (int j = 0; j < q.size(); ++j)
    q[j] = limits.lower[j] + share(rng) * (limits.upper[j] - limits.lower[j]);
  return q;
}

double brute_force(const std::vector<BodyCapsule>& bodies, const Canvas& canvas) {
  double least = kFarEnough;
  for (const BodyCapsule& body : bodies) {
    if (body.link == "pen") continue;
    constexpr int kPieces = 300;
    for (int i = 0; i <= kPieces; ++i) {
      const Vector3d p = body.a_W + (body.b_W - body.a_W) * i / kPieces;
      const auto nearest = canvas.closest(p, body.radius + least);
      if (nearest) least = std::min(least, std::abs(nearest->distance) - body.radius);
    }
  }
  return least;
}

TEST(Clearance, ArmAgreesWithBruteForceAlongRandomMotions) {
  const unsigned seed = 7;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  ArmModel arm(surfaces::kArm);
  TerrainSettings terrain;
  terrain.footprint.edge = 0.01;
  terrain.footprint.centre = {0.45, 0, 0.35};
  terrain.footprint.width = terrain.footprint.height = 0.5;
  const Canvas canvas(make_terrain(terrain));
  int near = 0, touching = 0;
  for (int motion = 0; motion < 40; ++motion) {
    JointVector q = random_posture(rng, arm.limits()), v = q;
    for (int j = 0; j < q.size(); ++j) v[j] = 0.03 * unit(rng);
    Clearance clearance(arm, &canvas, {}, 5e-3, kTip, q);
    for (int step = 0; step < 25; ++step, q += v) {
      const double truth = brute_force(arm.body_capsules(q), canvas), gap = clearance.arm(q).gap;
      if (truth < 0) {
        ++touching;
        EXPECT_LT(gap, 1e-3);
        continue;
      }
      near += truth < kFarEnough;
      EXPECT_GE(gap, truth - 5e-4);  // brute force looks at points only
      EXPECT_LE(gap, std::min(kFarEnough, truth / 0.9 + 1.3e-3));
    }
  }
  EXPECT_GT(near, 40);
  EXPECT_GT(touching, 40);
}

TEST(Clearance, WallAndTableAtAKnownDistance) {
  ArmModel arm(surfaces::kArm);
  const JointVector q = surfaces::start_posture(arm);
  double reach = 0, lowest = 1;
  std::string foremost, undermost;
  for (const BodyCapsule& body : arm.body_capsules(q)) {
    if (body.link == "pen") continue;
    const double x = std::max(body.a_W.x(), body.b_W.x()) + body.radius;
    if (x > reach) reach = x, foremost = body.link;
    if (body.link == "link_0" || body.link == "link_1") continue;  // they stand still
    const double z = std::min(body.a_W.z(), body.b_W.z()) - body.radius;
    if (z < lowest) lowest = z, undermost = body.link;
  }
  for (double d : {-0.01, 0.002, 0.012, 0.025}) {
    const Canvas wall(surfaces::wall(reach + d, 3, -1, 3));
    const Gap gap = Clearance(arm, &wall, {}, 5e-3, kTip, q).arm(q);
    EXPECT_NEAR(gap.gap, d, std::max(0.0, 0.12 * d) + 1.2e-3);
    EXPECT_EQ(gap.body, foremost);
    EXPECT_EQ(gap.obstacle, "canvas");
    const Gap table = Clearance(arm, nullptr, lowest - d, 5e-3, kTip, q).arm(q);
    EXPECT_NEAR(table.gap, d, 1e-12);
    EXPECT_EQ(table.body, undermost);
    EXPECT_EQ(table.obstacle, "table");
  }
  EXPECT_EQ(Clearance(arm, nullptr, 0.0, 5e-3, kTip, q).arm(q).gap, kFarEnough)
      << "the base stands on its table";
}

TEST(Clearance, PenAndAWallBesideIt) {
  ArmModel arm(surfaces::kArm);
  const JointVector q = surfaces::start_posture(arm);
  const Pose X_WE = arm.tip_pose(q);
  // The shaft is 5 mm thick and upright; 100 mm up the clearance is all asked.
  for (double d : {0.004, 0.008, 0.012, 0.03}) {
    const Canvas wall(surfaces::wall(X_WE.p.x() + d, 1, -1, 2));
    EXPECT_NEAR(Clearance(arm, &wall, {}, 5e-3, kTip, q).pen(q, X_WE).gap, d - 0.005 - 0.005, 2e-6);
  }
  // As low as 20 mm the clearance asked is 3 mm.
  const Canvas low(surfaces::wall(X_WE.p.x() + 0.009, 1, -1, X_WE.p.z() + 0.02));
  const Gap gap = Clearance(arm, &low, {}, 5e-3, kTip, q).pen(q, X_WE);
  EXPECT_GT(gap.gap, 0.0);
  EXPECT_LT(gap.gap, 0.009 - 0.005 - 0.02 * kPenOpening + 1e-6);
  EXPECT_GT(Clearance(arm, nullptr, X_WE.p.z(), 5e-3, kTip, q).pen(q, X_WE).gap, 0)
      << "drawing on the table itself";
}

// A pad's foam gives way.
TEST(Clearance, ALongerTipMayBeNear) {
  ArmModel arm(surfaces::kArm);
  const JointVector q = surfaces::start_posture(arm);
  const Pose X_WE = arm.tip_pose(q);
  const auto gap = [&](double top, double tip_length) {
    const Canvas low(surfaces::wall(X_WE.p.x() + 1e-3, 1, -1, X_WE.p.z() + top));
    return Clearance(arm, &low, {}, 5e-3, tip_length, q).pen(q, X_WE).gap;
  };
  EXPECT_LT(gap(0.007, kTip), 0.0);
  EXPECT_GT(gap(0.004, 0.01), 0.0);
  EXPECT_LT(gap(0.012, 0.01), 0.0);
}

TEST(Clearance, PenStandsOnASlopeOfUpTo53Degrees) {
  ArmModel arm(surfaces::kArm);
  const JointVector q = surfaces::start_posture(arm);
  const Pose X_WE = arm.tip_pose(q);
  // 5 mm thick from 10 mm up: the cone is as wide as its spheres, sin α = 5/√125; touching is cos θ
  // = sin α, 63.4°.
  for (double degrees : {0.0, 30.0, 45.0, 52.0, 53.0, 53.5, 55.0, 75.0}) {
    for (double turn : {0.0, 1.0, 2.5, 4.0}) {
      const double slope = degrees * std::numbers::pi / 180;
      PlaneSettings plane;
      plane.centre = X_WE.p;
      plane.normal = {std::sin(slope) * std::cos(turn), std::sin(slope) * std::sin(turn),
                      std::cos(slope)};
      plane.width = plane.height = 1;
      plane.edge = 0.1;
      const Canvas canvas(make_plane(plane));
      const Gap gap = Clearance(arm, &canvas, {}, 5e-3, kTip, q).pen(q, X_WE);
      EXPECT_EQ(gap.gap < 0, std::cos(slope) < 5 / std::sqrt(125.0) + kPenOpening)
          << degrees << "°, turned " << turn << ": " << gap.gap;
    }
  }
}

}  // namespace
}  // namespace impedraw
