// What a cloud shows of a table with an edge, with a hole, and below a ball.
#include "impedraw/perception/seen_surface.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

constexpr double kVoxel = 4e-3, kAround = 0.75 * kVoxel, kHalf = 20 * kVoxel, kHole = 0.012;  // [m]
const Eigen::Vector2d kHoleAt(-0.04, -0.04);

// A point in each voxel: the mean of those within lies anywhere in it.
PointCloud table_with_hole(std::mt19937* random) {
  std::uniform_real_distribution<double> within(-0.25 * kVoxel, 0.25 * kVoxel);
  PointCloud cloud;
  const auto add = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& n) {
    cloud.points.push_back(p);
    cloud.normals.push_back(n);
  };
  const int side = static_cast<int>(std::lround(kHalf / kVoxel));
  for (int i = -side; i <= side; ++i)
    for (int j = -side; j <= side; ++j) {
      const Eigen::Vector3d p(i * kVoxel + within(*random), j * kVoxel + within(*random), 0.0);
      if ((p.head<2>() - kHoleAt).norm() > kHole) add(p, Eigen::Vector3d::UnitZ());
    }
  // A ball's side stands over the line x = 40 mm, and the table goes on below.
  for (double z = 0.05; z < 0.09; z += kVoxel)
    for (double y = -kHalf; y <= kHalf; y += kVoxel)
      add({0.04 + within(*random), y, z}, Eigen::Vector3d::UnitX());
  return cloud;
}

TEST(SeenSurface, EndsAtEdgesAndHolesAndGoesOnBelowWhatHangsOver) {
  constexpr unsigned kSeed = 11;
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  const PointCloud cloud = table_with_hole(&random);
  const SeenSurface seen(cloud, kVoxel, kAround);
  std::uniform_real_distribution<double> side(-0.1, 0.1);
  int below = 0;
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3d p(side(random), side(random), 0.0);
    SCOPED_TRACE(testing::Message() << p.transpose());
    const double beyond = p.head<2>().lpNorm<Eigen::Infinity>() - kHalf,
                 to_hole = (p.head<2>() - kHoleAt).norm() - kHole;
    // A quarter of a voxel beyond the edge on average, a quarter of one more or less by the points.
    if (beyond > 0.6 * kVoxel || to_hole < -0.6 * kVoxel) EXPECT_FALSE(seen(p));
    if (beyond < -0.1 * kVoxel && to_hole > kVoxel) EXPECT_TRUE(seen(p));
    below += std::abs(p.x() - 0.04) < 1e-3 && seen(p);
  }
  EXPECT_GT(below, 30);
  EXPECT_FALSE(seen({0.0, 0.0, 0.01}));  // off the surface
}

TEST(SeenSurface, IsNotWhereAPointHasNoNormal) {
  PointCloud cloud;
  cloud.points.assign(1, Eigen::Vector3d::Zero());
  cloud.normals.assign(1, Eigen::Vector3d::Constant(std::nan("")));
  EXPECT_FALSE(SeenSurface(cloud, 0.01, 1e-3)(Eigen::Vector3d::Zero()));
}

}  // namespace
}  // namespace impedraw
