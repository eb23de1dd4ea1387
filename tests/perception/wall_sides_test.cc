// Walls whose two surfaces are known: the points say themselves on which they lie.
#include "impedraw/perception/wall_sides.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr double kVoxel = 4e-3, kSpacing = 1.5e-3;  // [m]

// Two cameras that see the sides of an upright plate from opposite places.
PointCloud plate(double thickness) {
  PointCloud cloud;
  cloud.eyes = {{0.0, 1.0, 0.3}, {0.0, -1.0, 0.3}};
  for (const int camera : {0, 1})
    for (double x = -0.1; x < 0.1; x += kSpacing)
      for (double z = 0.0; z < 0.1; z += kSpacing) {
        cloud.points.emplace_back(x, (camera == 0 ? 0.5 : -0.5) * thickness, z);
        cloud.camera.push_back(camera);
      }
  return cloud;
}

TEST(WallSides, OneSideOfAThinPlateIsLeft) {
  for (const double thickness : {0.0, 2e-3}) {
    const PointCloud both = plate(thickness);
    const PointCloud one = without_far_sides(both, kVoxel, NormalSettings());
    EXPECT_EQ(one.points.size(), both.points.size() / 2) << thickness;
    // What the surface is fitted to tells one normal all over.
    const SurfaceEstimator surface(thin(one, kVoxel), NormalSettings());
    for (double x = -0.08; x < 0.08; x += 0.003)
      for (double z = 0.02; z < 0.08; z += 0.003) {
        const SurfaceEstimate at = surface.estimate({x, 0.5 * thickness, z});
        ASSERT_EQ(at.status, SurfaceStatus::ok);
        EXPECT_NEAR(at.n_W.y(), 1.0, 1e-6);
        EXPECT_NEAR(at.distance, 0.0, 1e-6);
      }
  }
}

TEST(WallSides, AThickPlateKeepsBoth) {
  const PointCloud both = plate(10e-3);
  EXPECT_EQ(without_far_sides(both, kVoxel, NormalSettings()).points.size(), both.points.size());
}

TEST(WallSides, OneViewStaysAsItIs) {
  PointCloud both = plate(0.0);
  both.eyes.resize(1);
  std::fill(both.camera.begin(), both.camera.end(), 0);
  EXPECT_EQ(without_far_sides(both, kVoxel, NormalSettings()).points.size(), both.points.size());
}

// A pipe that stands open, of which each of four cameras sees the near outside and the far inside,
// the inside in twice as many pixels.
TEST(WallSides, TheOutsideOfAVesselIsLeft) {
  constexpr double kRadius = 0.06, kWall = 2e-3;
  PointCloud cloud;
  for (int camera = 0; camera < 4; ++camera) {
    const double towards = camera * std::numbers::pi / 2;
    cloud.eyes.emplace_back(std::cos(towards), std::sin(towards), 0.8);
    for (double a = -1.4; a < 1.4; a += kSpacing / kRadius)
      for (double z = 0.0; z < 0.12; z += kSpacing) {
        const Vector3d near(std::cos(towards + a), std::sin(towards + a), 0.0), up(0.0, 0.0, z);
        cloud.points.push_back(kRadius * near + up);
        for (const double lower : {0.0, 0.5 * kSpacing})
          cloud.points.emplace_back(-(kRadius - kWall) * near + up + Vector3d(0.0, 0.0, lower));
        cloud.camera.insert(cloud.camera.end(), 3, camera);
      }
  }
  const PointCloud left = without_far_sides(cloud, kVoxel, NormalSettings());
  EXPECT_EQ(left.points.size(), cloud.points.size() / 3);
  for (const Vector3d& p : left.points) EXPECT_NEAR(p.head<2>().norm(), kRadius, 1e-9);
}

}  // namespace
}  // namespace impedraw
