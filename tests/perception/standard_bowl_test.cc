// The whole way on the standard bowl: canvas, three cameras, cloud, normal and distance along the
// sine.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "impedraw/canvas/built_in.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/perception/normals.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

const Vector3d kCentre(0.60, 0.0, 0.40);

class StandardBowl : public testing::Test {
 protected:
  static PointCloud cloud(const DepthNoise& noise, double voxel) {
    static const Canvas canvas(make_bowl());
    const auto cast = [](const Vector3d& origin, const Vector3d& direction) {
      const auto hit = canvas.ray(origin, direction);
      return hit ? hit->t : std::numeric_limits<double>::infinity();
    };
    const auto cameras = standard_cameras();
    std::vector<DepthImage> images;
    for (std::size_t c = 0; c < cameras.size(); ++c)
      images.push_back(render_depth(cameras[c], cast, noise, 10 + c));
    return fuse(images, cameras, {.voxel = voxel});
  }

  static const PointCloud& perfect() {
    static const PointCloud c = cloud({}, CloudSettings().voxel);
    return c;
  }
};

struct Figures {
  double normal_mean = 0, normal_max = 0, distance_max = 0;  // [deg, deg, mm]
};

// Every mm of the sine, the query 0.75 mm above the surface.
Figures along_sine(const SurfaceEstimator& estimator) {
  Figures f;
  const int n = 300;
  for (int i = 0; i <= n; ++i) {
    const double y = -0.15 + 0.30 * i / n,
                 x = 0.05 * std::sin(2 * std::numbers::pi * (y + 0.15) / 0.15);
    const Vector3d inward = -Vector3d(x, y, -std::sqrt(0.09 - x * x - y * y)).normalized();
    const SurfaceEstimate e = estimator.estimate(kCentre - (0.30 - 0.00075) * inward);
    EXPECT_EQ(e.status, SurfaceStatus::ok);
    const double angle =
        std::atan2(e.n_W.cross(inward).norm(), e.n_W.dot(inward)) * 180 / std::numbers::pi;
    f.normal_mean += angle / (n + 1);
    f.normal_max = std::max(f.normal_max, angle);
    f.distance_max = std::max(f.distance_max, 1e3 * std::abs(e.distance - 0.00075));
  }
  return f;
}

TEST_F(StandardBowl, PerfectCamerasGiveACloudOnTheSurface) {
  const PointCloud& c = perfect();
  double mean = 0;
  for (const auto& p : c.points) mean += 1e3 * (0.30 - (p - kCentre).norm()) / c.points.size();
  EXPECT_NEAR(mean, 0, 0.01);  // [mm]; asked for: 0.05
  EXPECT_GT(c.points.size(), 7000u);
}

TEST_F(StandardBowl, PerfectCameras) {
  const Figures f = along_sine(SurfaceEstimator(perfect()));
  EXPECT_LT(f.normal_mean, 0.005);  // asked for: 0.1°, 0.4°, 0.1 mm
  EXPECT_LT(f.normal_max, 0.02);
  EXPECT_LT(f.distance_max, 0.01);
}

TEST_F(StandardBowl, ThePapersPlaneHasItsCurvatureBias) {
  const PointCloud& c = perfect();
  const Figures f = along_sine(
      SurfaceEstimator(c, {.weighting = NeighbourWeighting::uniform, .fit = SurfaceFit::plane}));
  EXPECT_LT(f.normal_mean, 0.12);
  EXPECT_GT(f.distance_max, 0.15);
}

TEST_F(StandardBowl, RealisticNoise) {
  const PointCloud c = cloud(realistic_depth_noise(), 0.006);
  double mean = 0, weight = 0;
  for (std::size_t i = 0; i < c.points.size(); ++i) {
    mean += c.weight[i] * 1e3 * (0.30 - (c.points[i] - kCentre).norm());
    weight += c.weight[i];
  }
  EXPECT_NEAR(mean / weight, 0, 0.02);  // [mm]
  const Figures f = along_sine(SurfaceEstimator(c, {.k = 90}));
  EXPECT_LT(f.normal_mean, 0.3);
  EXPECT_LT(f.normal_max, 0.8);
  EXPECT_LT(f.distance_max, 0.3);
}

}  // namespace
}  // namespace impedraw
