#include "impedraw/perception/cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

CastRay tilted_plane(const Vector3d& n, double d) {
  return [=](const Vector3d& origin, const Vector3d& direction) {
    return (d - n.dot(origin)) / n.dot(direction);
  };
}

std::vector<DepthImage> render(const std::vector<DepthCamera>& cameras, const CastRay& cast) {
  std::vector<DepthImage> images;
  for (const auto& camera : cameras) images.push_back(render_depth(camera, cast));
  return images;
}

TEST(BackProject, EveryPixelsPointLiesOnTheSurfaceAndInItsPixel) {
  const Vector3d n = Vector3d(0.1, -0.2, 1).normalized();
  const auto cameras = standard_cameras();
  const PointCloud cloud = back_project(render(cameras, tilted_plane(n, 0.1)), cameras, {});
  ASSERT_EQ(cloud.points.size(), 3u * 640 * 480);
  const double f = 240 / std::tan(30 * 3.14159265358979323846 / 180);
  for (std::size_t k = 0; k < cloud.points.size(); k += 7) {
    const int camera = int(k / (640 * 480)), i = int(k % 640), j = int(k / 640 % 480);
    EXPECT_EQ(cloud.camera[k], camera);
    EXPECT_NEAR(n.dot(cloud.points[k]), 0.1, 1e-13);
    const Vector3d p_C = cameras[camera].X_WC.inverse() * cloud.points[k];
    EXPECT_NEAR(f * p_C.x() / p_C.z() + 320, i + 0.5,
                1e-9);  // measured from the image's left edge, in pixels
    EXPECT_NEAR(f * p_C.y() / p_C.z() + 240, j + 0.5, 1e-9);
  }
  for (int c = 0; c < 3; ++c) EXPECT_EQ(cloud.eyes[c], cameras[c].X_WC.p);
}

TEST(BackProject, KeepsTheRegionAndLosesTheArm) {
  const auto cameras = standard_cameras();
  const auto images = render(cameras, tilted_plane(Vector3d::UnitZ(), 0.1));
  const PointCloud all = back_project(images, cameras, {});
  CloudSettings settings;
  settings.region = {Vector3d(0.4, -0.2, 0.0), Vector3d(0.8, 0.2, 0.2)};
  settings.self_padding = 0.02;
  const std::vector<Capsule> arm = {{{0.5, 0, 0.2}, {0.7, 0.1, 0.08}, 0.03},
                                    {{0.6, -0.1, 0.1}, {0.6, -0.1, 0.1}, 0.01}};
  const PointCloud kept = back_project(images, cameras, settings, arm);

  std::size_t next = 0, cropped = 0, hidden = 0;
  for (std::size_t k = 0; k < all.points.size(); k += 1) {
    const Vector3d& p = all.points[k];
    if (p.x() < 0.4 || p.x() > 0.8 || p.y() < -0.2 || p.y() > 0.2) {
      ++cropped;
      continue;
    }
    // by 400 spheres along each capsule
    double clearance = std::numeric_limits<double>::infinity();
    for (const auto& c : arm) {
      for (int s = 0; s <= 400; ++s)
        clearance =
            std::min(clearance, (c.a_W + (c.b_W - c.a_W) * (s / 400.0) - p).norm() - c.radius);
    }
    const bool was_kept = next < kept.points.size() && kept.points[next] == p;
    if (std::abs(clearance - 0.02) > 1e-5) {
      EXPECT_EQ(was_kept, clearance > 0.02);
    }
    hidden += !was_kept;
    next += was_kept;
  }
  EXPECT_EQ(next, kept.points.size());
  EXPECT_GT(cropped, 100000u);
  EXPECT_GT(hidden, 1000u);
  EXPECT_GT(kept.points.size(), 10000u);
}

TEST(Thin, OnePointACubeByBruteForce) {
  for (const unsigned seed : {1u, 2u}) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-0.1, 0.1);
    PointCloud cloud;
    cloud.eyes.resize(3);
    for (int i = 0; i < 5000; ++i) {
      cloud.points.emplace_back(uniform(random), uniform(random), 0.1 * uniform(random));
      cloud.camera.push_back(int(random() % 3));
    }
    struct Cube {
      Vector3d sum = Vector3d::Zero();
      std::array<int, 3> seen{};
      int n = 0;
    };
    std::map<std::array<long, 3>, Cube> cubes;
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
      const auto& p = cloud.points[i];
      const auto cell = [](double x) { return std::lround(std::floor(x / 0.013)); };
      Cube& cube = cubes[{cell(p.x()), cell(p.y()), cell(p.z())}];
      cube.sum += p;
      ++cube.seen[cloud.camera[i]];
      ++cube.n;
    }
    const PointCloud thinned = thin(cloud, 0.013);
    ASSERT_EQ(thinned.points.size(), cubes.size());
    std::size_t i = 0;
    for (const auto& [key, cube] : cubes) {
      EXPECT_LT((thinned.points[i] - cube.sum / cube.n).norm(), 1e-15);
      EXPECT_EQ(thinned.weight[i], cube.n);
      EXPECT_EQ(cube.seen[thinned.camera[i]],
                *std::max_element(cube.seen.begin(), cube.seen.end()));
      ++i;
    }
    EXPECT_EQ(thin(cloud, 0).points, cloud.points);
  }
}

TEST(Thin, KeepsTheMeanWhenThinnedTwice) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 0.1);
  PointCloud cloud;
  cloud.eyes.resize(1);
  for (int i = 0; i < 1000; ++i) {
    cloud.points.emplace_back(uniform(random), uniform(random), uniform(random));
    cloud.camera.push_back(0);
  }
  Vector3d mean = Vector3d::Zero();
  for (const auto& p : cloud.points) mean += p / 1000;
  const PointCloud one = thin(thin(cloud, 0.01), 0.1);
  ASSERT_EQ(one.points.size(), 1u);
  EXPECT_LT((one.points[0] - mean).norm(), 1e-14);
  EXPECT_EQ(one.weight[0], 1000);
}

TEST(Fuse, RefusesBadSettingsByName) {
  std::vector<DepthCamera> cameras(1);
  cameras[0].width = cameras[0].height = 2;
  cameras[0].X_WC = look_at({0, 0, 1}, {0, 0, 0});
  const auto images = render(cameras, tilted_plane(Vector3d::UnitZ(), 0));
  const auto expect_refused = [](const std::function<void()>& f, const std::string& what) {
    try {
      f();
      ADD_FAILURE() << "accepted, though " << what;
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), testing::HasSubstr(what));
    }
  };
  EXPECT_NO_THROW(fuse(images, cameras));
  expect_refused([&] { fuse(images, {}); }, "1 depth images for 0 cameras");
  expect_refused([&] { fuse({{2, 1, {1, 1}}}, cameras); }, "image 0 has 2 × 1 px");
  expect_refused([&] { fuse(images, cameras, {.voxel = -1}); }, "cloud.voxel is -1 m");
  expect_refused([&] { fuse(images, cameras, {.voxel = std::nan("")}); }, "cloud.voxel is nan m");
  expect_refused([&] { fuse(images, cameras, {.voxel = 1e-9}); }, "too small");
  expect_refused([&] { fuse(images, cameras, {.region = Eigen::AlignedBox3d()}); },
                 "region is empty");
  expect_refused([&] { fuse(images, cameras, {.self_padding = -0.1}); },
                 "cloud.self_padding is -0.1 m");
  expect_refused(
      [&] {
        fuse(images, cameras, {}, {{{0, 0, 0}, {0, 0, std::nan("")}, 0.1}});
      },
      "capsule 0");
}

}  // namespace
}  // namespace impedraw
