// Faults of a stereo camera against their closed forms, over many pixels and many cameras.
#include "impedraw/perception/stereo_faults.h"

#include <cmath>
#include <cstring>
#include <numbers>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr double kQuantum = 1.0 / 32.0 / (421.0 * 0.05);  // of 1/z [1/m]

DepthCamera camera() { return {320, 240, 60.0, {}}; }

DepthImage level(double z) { return {320, 240, std::vector<double>(320 * 240, z)}; }

DepthImage seen(DepthImage image, double sigma, std::uint64_t seed = 7, double factor = 1.0) {
  StereoFaults(factor, seed).disturb(sigma, seed, {0, 0, 320, 240}, camera(), &image);
  return image;
}

// Mean, and share of the pixels that measured something.
std::pair<double, double> mean_of(const DepthImage& image) {
  double sum = 0.0, n = 0.0;
  for (const double z : image.depth)
    if (std::isfinite(z)) sum += z, ++n;
  return {sum / n, n / static_cast<double>(image.depth.size())};
}

// The noise is c smoothed with a standard deviation s: its correlation over k pixels is
// exp(−k²/4s²), and its variance σ₁² z⁴, to which the steps add q² z⁴ / 12.
TEST(StereoFaults, NoiseHangsTogetherOverSomePixels) {
  const double sigma = 0.004, z = 1.2;
  double variance = 0.0, beside = 0.0, below = 0.0, n = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const DepthImage image = seen(level(z), sigma, seed);
    const double mean = mean_of(image).first;
    for (int j = 0; j + 3 < 240; ++j)
      for (int i = 0; i + 3 < 320; ++i) {
        const double a = image.at(i, j) - mean, b = image.at(i + 2, j) - mean,
                     c = image.at(i, j + 3) - mean;
        if (!std::isfinite(a + b + c)) continue;
        variance += a * a, beside += a * b, below += a * c, ++n;
      }
  }
  const double steps = kQuantum * kQuantum / 12.0, all = sigma * sigma + steps;
  EXPECT_NEAR(std::sqrt(variance / n), std::sqrt(all) * z * z, 0.02 * sigma * z * z);
  EXPECT_NEAR(beside / variance, sigma * sigma / all * std::exp(-4.0 / 9.0), 0.02);
  EXPECT_NEAR(below / variance, sigma * sigma / all * std::exp(-1.0), 0.02);
}

TEST(StereoFaults, InverseDepthsAreWholeSteps) {
  for (const double z : seen(level(0.9), 1e-3).depth)
    if (std::isfinite(z)) {
      ASSERT_NEAR(std::remainder(1.0 / z, kQuantum), 0.0, 1e-9);
    }
}

TEST(StereoFaults, PixelsBesideAStepFlyAndFewAreLost) {
  DepthImage image = level(0.8);
  for (int j = 0; j < 240; ++j)
    for (int i = 160; i < 320; ++i) image.depth[static_cast<std::size_t>(j) * 320 + i] = 1.0;
  const DepthImage measured = seen(image, 0.0);
  int between = 0, lost = 0;
  for (int j = 0; j < 240; ++j)
    for (int i = 0; i < 320; ++i) {
      const double z = measured.at(i, j);
      lost += !std::isfinite(z) && i != 160;
      const bool flies = z > 0.82 && z < 0.98;
      between += flies;
      EXPECT_TRUE(!flies || i == 160) << i;
    }
  EXPECT_NEAR(between / 240.0, 0.7 * 0.8, 0.1);  // of the mixtures, 0.8 lie in that range
  EXPECT_NEAR(lost / (319.0 * 240.0), 0.01, 0.003);
}

// A plane at an angle to the rays, of which the camera sees a small part.
TEST(StereoFaults, SteepSurfacesHaveHoles) {
  const double f = camera().focal_length();
  for (const auto& [degrees, share] : {std::pair{60.0, 0.99}, {80.0, 0.3 * 0.99}}) {
    DepthImage image = level(1.0);
    const double slope = std::tan(degrees * std::numbers::pi / 180.0);
    for (int j = 0; j < 240; ++j)
      for (int i = 0; i < 320; ++i)
        image.depth[static_cast<std::size_t>(j) * 320 + i] =
            1.0 / (1.0 - slope * (j - 120) / f * 0.1);
    // Ten times finer than a pixel: the slope in pixels is a tenth.
    DepthCamera fine = camera();
    fine.fov_y_deg = 2.0 * std::atan(std::tan(fine.fov_y_deg * std::numbers::pi / 360.0) / 10.0) *
                     180.0 / std::numbers::pi;
    StereoFaults(1.0, 3).disturb(0.0, 3, {0, 0, 320, 240}, fine, &image);
    EXPECT_NEAR(mean_of(image).second, share, 0.05) << degrees;
  }
}

TEST(StereoFaults, EachCameraHasABiasAndALensOfItsOwn) {
  double bias = 0.0, middle = 0.0, radial = 0.0;
  constexpr int kCameras = 400;
  for (std::uint64_t seed = 0; seed < kCameras; ++seed) {
    const StereoFaults faults(1.0, seed);
    const Vector3d on_axis = faults.seen_along({0, 0, 1}), right = faults.seen_along({0.5, 0, 1}),
                   left = faults.seen_along({-0.5, 0, 1}),
                   near = faults.seen_along({0.1, 0, 1}) - on_axis;
    bias += std::pow(faults.found_at({0, 0, 1.0}).z() - 1.0, 2) / kCameras;
    middle += on_axis.head<2>().squaredNorm() / 2 / kCameras;
    radial +=
        std::pow(((right - left).x() - 10.0 * near.x()) / 0.24, 2) / kCameras;  // k (r² − r'²)
    // What is found is what is seen.
    const Vector3d p(0.2, -0.1, 0.9), found = faults.found_at(p);
    EXPECT_LT((faults.seen_along(found / found.z()) - p / p.z()).norm(), 1e-9);
  }
  EXPECT_NEAR(std::sqrt(bias), 0.0025, 0.0003);
  EXPECT_NEAR(std::sqrt(middle), 0.71 / 554.0, 0.1e-3);
  EXPECT_NEAR(std::sqrt(radial), 0.0037, 0.0005);
}

// Rays that are believed to go elsewhere give the depths of where they do go.
TEST(StereoFaults, BentRaysGiveTheDepthsOfWhatIsSeen) {
  const StereoFaults faults(3.0, 5);
  DepthCamera c = camera();
  c.X_WC = look_at({0.3, 0.1, 0.9}, {0, 0, 0});
  const CastRays ground = [](const Vector3d& o, std::span<const Vector3d> d, std::span<double> t) {
    for (std::size_t k = 0; k < d.size(); ++k) t[k] = -o.z() / d[k].z();
  };
  const DepthImage image = render_depth(c, faults.bent(c, ground), {}, 1, 1);
  for (int i = 10; i < 320; i += 60)
    for (int j = 10; j < 240; j += 60) {
      const Vector3d p_C = image.at(i, j) * faults.seen_along(c.direction_C(i, j));
      EXPECT_NEAR((c.X_WC * p_C).z(), 0.0, 1e-9);
    }
}

TEST(StereoFaults, APartIsAPartOfTheWholeAndNoneIsNone) {
  const DepthImage whole = seen(level(0.9), 1e-3);
  DepthImage part = level(0.9);
  StereoFaults(1.0, 7).disturb(1e-3, 7, {40, 50, 100, 90}, camera(), &part);
  for (int j = 50; j < 90; ++j)
    for (int i = 40; i < 100; ++i) {
      const double a = part.at(i, j), b = whole.at(i, j);
      ASSERT_EQ(std::memcmp(&a, &b, sizeof a), 0) << i << ' ' << j;
    }
  DepthImage exact = level(0.9);
  StereoFaults().disturb(1e-3, 7, {0, 0, 320, 240}, camera(), &exact);
  EXPECT_EQ(exact.depth, level(0.9).depth);
}

}  // namespace
}  // namespace impedraw
