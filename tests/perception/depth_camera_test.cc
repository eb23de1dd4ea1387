#include "impedraw/perception/depth_camera.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A plane n · p = d, from either side.
CastRay plane(const Vector3d& n, double d) {
  return [=](const Vector3d& origin, const Vector3d& direction) {
    const double t = (d - n.dot(origin)) / n.dot(direction);
    return t > 0 ? t : kInfinity;
  };
}

TEST(DepthCamera, PixelsLookThroughTheirMiddles) {
  DepthCamera camera;
  camera.width = 4;
  camera.height = 2;
  // the image plane at z = 1 reaches from y = −1 to 1 and, with square pixels, from x = −2 to 2
  camera.fov_y_deg = 90;
  EXPECT_LT((camera.direction_C(0, 0) - Vector3d(-1.5, -0.5, 1)).norm(), 1e-15);
  EXPECT_LT((camera.direction_C(3, 0) - Vector3d(1.5, -0.5, 1)).norm(), 1e-15);
  EXPECT_LT((camera.direction_C(1, 1) - Vector3d(-0.5, 0.5, 1)).norm(), 1e-15);
}

TEST(DepthCamera, LooksAtItsTargetUpright) {
  const Vector3d eye(1.1, 0.3, 0.9), target(0.6, 0, 0.1);
  const Pose X = look_at(eye, target);
  EXPECT_LT((X.R.transpose() * X.R - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_NEAR(X.R.determinant(), 1, 1e-14);
  const Vector3d target_C = X.inverse() * target;
  EXPECT_LT((target_C - Vector3d(0, 0, (target - eye).norm())).norm(), 1e-14);
  EXPECT_LT((X.inverse() * (target + Vector3d(0, 0, 0.1))).y(),
            -0.01);  // up in the world is up in the image: y falls
  EXPECT_NEAR((X.inverse() * (target + Vector3d(0, 0, 0.1))).x(), 0, 1e-14);
  const Vector3d right = (target - eye).cross(Vector3d::UnitZ());
  EXPECT_GT((X.inverse() * (target + right)).x(), 0.1);
  const Pose down = look_at({0, 0, 1}, {0, 0, 0});  // along z, where there is no upright
  EXPECT_NEAR(down.R.determinant(), 1, 1e-14);
  EXPECT_LT((down.R.col(2) + Vector3d::UnitZ()).norm(), 1e-14);
}

TEST(DepthCamera, StandardCamerasStandWhereTheyShould) {
  const auto cameras = standard_cameras();
  ASSERT_EQ(cameras.size(), 3u);
  for (int c = 0; c < 3; ++c) {
    const Vector3d from_axis = cameras[c].X_WC.p - Vector3d(0.6, 0, 0.9);
    EXPECT_NEAR(from_axis.z(), 0, 1e-15);
    EXPECT_NEAR(from_axis.norm(), 0.5, 1e-14);
    EXPECT_NEAR(
        std::remainder(std::atan2(from_axis.y(), from_axis.x()) - c * 2 * std::numbers::pi / 3,
                       2 * std::numbers::pi),
        0, 1e-14);
    EXPECT_LT((cameras[c].X_WC.inverse() * Vector3d(0.6, 0, 0.1)).head<2>().norm(), 1e-14);
    EXPECT_EQ(cameras[c].width, 640);
    EXPECT_EQ(cameras[c].height, 480);
    EXPECT_EQ(cameras[c].fov_y_deg, 60);
  }
}

TEST(RenderDepth, DepthIsAlongTheCamerasAxis) {
  DepthCamera camera;
  camera.width = 64;
  camera.height = 48;
  camera.X_WC = look_at({0, 0, 1.25}, {0, 0, 0});
  const DepthImage image = render_depth(camera, plane(Vector3d::UnitZ(), 0));
  for (const double depth : image.depth) EXPECT_NEAR(depth, 1.25, 1e-14);
}

TEST(RenderDepth, NothingIsNaN) {
  DepthCamera camera;
  camera.X_WC =
      look_at({0, 0, 1},
              {1, 0, 1});  // level: the lower half of the image sees the ground, the upper nothing
  const DepthImage image =
      render_depth(camera, plane(Vector3d::UnitZ(), 0), realistic_depth_noise());
  EXPECT_TRUE(std::isnan(image.at(320, 0)));
  EXPECT_TRUE(std::isnan(image.at(0, 239)));
  EXPECT_TRUE(std::isfinite(image.at(0, 479)));
}

TEST(RenderDepth, NoiseGrowsAsTheModelSays) {
  DepthCamera camera;
  for (const double distance : {0.5, 1.0, 2.0}) {
    SCOPED_TRACE(distance);
    camera.X_WC = look_at({0, 0, distance}, {0, 0, 0});
    const DepthImage image =
        render_depth(camera, plane(Vector3d::UnitZ(), 0), realistic_depth_noise(), 42);
    const double n = double(image.depth.size());
    double mean = 0, second = 0, fourth = 0, neighbours = 0;
    for (const double depth : image.depth) mean += (depth - distance) / n;
    for (std::size_t i = 0; i < image.depth.size(); ++i) {
      const double e = image.depth[i] - distance - mean;
      second += e * e / n;
      fourth += e * e * e * e / n;
      if (i > 0) neighbours += e * (image.depth[i - 1] - distance - mean) / n;
    }
    const double sigma = 0.001 * distance * distance;
    EXPECT_NEAR(mean, 0, 4 * sigma / std::sqrt(n));
    EXPECT_NEAR(std::sqrt(second), sigma, 0.006 * sigma);   // 4 σ of the estimate
    EXPECT_NEAR(fourth / (second * second), 3, 0.05);       // Gaussian
    EXPECT_NEAR(neighbours / second, 0, 4 / std::sqrt(n));  // independent
  }
}

TEST(RenderDepth, SameSeedSameImageOnAnyNumberOfThreads) {
  DepthCamera camera;
  camera.width = 120;
  camera.height = 90;
  camera.X_WC = look_at({0.3, 0, 1}, {0, 0, 0});
  const auto render = [&](std::uint64_t seed, int threads) {
    return render_depth(camera, plane(Vector3d::UnitZ(), 0), realistic_depth_noise(), seed, threads)
        .depth;
  };
  const auto one = render(5, 1);
  for (const int threads : {0, 2, 3, 8}) EXPECT_EQ(render(5, threads), one);
  const auto other = render(6, 1);
  int same = 0;
  for (std::size_t i = 0; i < one.size(); ++i) same += one[i] == other[i];
  EXPECT_LT(same, 5);
}

// A box that turns and moves: no ray beside its pixels meets it, and they are not many more.
TEST(RenderDepth, PixelsOfABoxHoldAllThatSeeIt) {
  DepthCamera camera;
  camera.width = 160;
  camera.height = 120;
  camera.X_WC = look_at({0.3, 0.1, 1}, {0, 0, 0});
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-0.1, -0.05, 0.0), Eigen::Vector3d(0.1, 0.05, 0.1));
  for (int k = 0; k < 40; ++k) {
    Pose X_WB;
    X_WB.p = 0.02 * k * Eigen::Vector3d(std::cos(k), std::sin(k), 0.3 * std::sin(2.0 * k));
    X_WB.R = Eigen::AngleAxisd(0.3 * k, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    const PixelBox part = pixels_of(camera, box, X_WB);
    const Pose X_BW = X_WB.inverse();
    int seeing = 0;
    for (int j = 0; j < camera.height; ++j)
      for (int i = 0; i < camera.width; ++i) {
        const Eigen::Vector3d o = X_BW * camera.X_WC.p,
                              d = X_BW.R * (camera.X_WC.R * camera.direction_C(i, j));
        double from = 0.0, to = 1e9;
        for (int a = 0; a < 3; ++a) {
          const double one = (box.min()[a] - o[a]) / d[a], other = (box.max()[a] - o[a]) / d[a];
          from = std::max(from, std::min(one, other));
          to = std::min(to, std::max(one, other));
        }
        if (from > to) continue;
        ++seeing;
        EXPECT_TRUE(i >= part.left && i < part.right && j >= part.top && j < part.bottom)
            << i << ' ' << j;
      }
    const int all = (part.right - part.left) * (part.bottom - part.top);
    if (seeing > 0) {
      EXPECT_LT(all, 4 * seeing + 2000) << k;
    }
  }
  const PixelBox behind = pixels_of(camera, box, {{0, 0, 2}, Eigen::Matrix3d::Identity()});
  EXPECT_EQ(behind.right - behind.left, camera.width) << "not all of it is before the camera";
}

TEST(RenderDepth, APartIsAsInTheWholeImage) {
  DepthCamera camera;
  camera.width = 120;
  camera.height = 90;
  camera.X_WC = look_at({0.3, 0, 1}, {0, 0, 0});
  const CastRay one = plane(Vector3d::UnitZ(), 0);
  const CastRays rays = [&](const Vector3d& o, std::span<const Vector3d> d, std::span<double> out) {
    for (std::size_t k = 0; k < d.size(); ++k) out[k] = one(o, d[k]);
  };
  const DepthImage whole = render_depth(camera, one, realistic_depth_noise(), 3, 1);
  DepthImage part;
  render_depth(camera, rays, realistic_depth_noise(), 3, {10, 20, 95, 41}, &part);
  for (int j = 0; j < camera.height; ++j)
    for (int i = 0; i < camera.width; ++i) {
      if (i >= 10 && i < 95 && j >= 20 && j < 41)
        EXPECT_EQ(part.at(i, j), whole.at(i, j));
      else
        EXPECT_TRUE(std::isnan(part.at(i, j)));
    }
}

TEST(RenderDepth, RefusesBadSettingsByName) {
  const auto expect_refused = [](const std::function<void()>& f, const std::string& what) {
    try {
      f();
      ADD_FAILURE() << "accepted, though " << what;
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), testing::HasSubstr(what));
    }
  };
  const auto render = [](DepthCamera camera, DepthNoise noise = {}) {
    render_depth(camera, plane(Vector3d::UnitZ(), 0), noise);
  };
  expect_refused([&] { render({.width = 0}); }, "camera.width is 0 px");
  expect_refused([&] { render({.fov_y_deg = 180}); }, "camera.fov_y is 180 deg");
  expect_refused([&] { render({.fov_y_deg = std::nan("")}); }, "camera.fov_y is nan deg");
  expect_refused(
      [&] {
        render({.X_WC = {{0, 0, kInfinity}, Eigen::Matrix3d::Identity()}});
      },
      "X_WC");
  expect_refused([&] { render({}, {.sigma_at_1m = -1}); }, "noise.sigma_at_1m is -1 m");
  expect_refused([&] { render({}, {.sigma_at_1m = std::nan("")}); }, "noise.sigma_at_1m is nan m");
  expect_refused([] { look_at({1, 1, 1}, {1, 1, 1}); }, "eye (1, 1, 1)");
}

}  // namespace
}  // namespace impedraw
