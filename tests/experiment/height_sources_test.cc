// The height that a cloud shows, beside a ball above a table.
#include "impedraw/experiment/height_sources.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "impedraw/perception/normals.h"

namespace impedraw {
namespace {

constexpr double kVoxel = 4e-3, kHeight = 0.1, kRadius = 0.04, kNoise = 0.4e-3;  // [m]

PointCloud ball_over_table(std::mt19937* random) {
  std::uniform_real_distribution<double> within(-0.5 * kVoxel, 0.5 * kVoxel);
  std::normal_distribution<double> noise(0.0, kNoise);
  PointCloud cloud;
  for (double x = -0.1; x <= 0.1; x += kVoxel)
    for (double y = -0.1; y <= 0.1; y += kVoxel)
      cloud.points.emplace_back(x + within(*random), y + within(*random), noise(*random));
  for (double polar = 0.0; polar <= 2.0; polar += kVoxel / kRadius)
    for (double turn = 0.0; turn < 2.0 * std::numbers::pi;
         turn += kVoxel / (kRadius * std::max(0.1, std::sin(polar)))) {
      const Eigen::Vector3d n(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn),
                              std::cos(polar));
      cloud.points.emplace_back(Eigen::Vector3d(0.0, 0.0, kHeight) +
                                (kRadius + noise(*random)) * n);
    }
  // Four cameras stand around, a little higher than the ball.
  cloud.eyes = {{1.0, 0.0, 0.2}, {0.0, 1.0, 0.2}, {-1.0, 0.0, 0.2}, {0.0, -1.0, 0.2}};
  for (const Eigen::Vector3d& p : cloud.points) {
    const double turn = std::atan2(p.y(), p.x()) / (0.5 * std::numbers::pi);
    cloud.camera.push_back((static_cast<int>(std::lround(turn)) + 4) % 4);
  }
  return cloud;
}

TEST(PerceivedHeight, TheTableBeginsWhereTheBallAboveEnds) {
  constexpr unsigned kSeed = 7;
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  const auto surface = std::make_shared<const SurfaceEstimator>(ball_over_table(&random));
  const SurfaceHeight height = perceived_height(surface, Pose());
  std::uniform_real_distribution<double> side(-0.07, 0.07);
  int table = 0, known = 0;
  for (int i = 0; i < 20000; ++i) {
    const double x = side(random), y = side(random), off = std::hypot(x, y) - kRadius;
    SCOPED_TRACE(off);
    SurfaceHeight::Sample none;
    const auto here = height(x, y, none);
    if (off > 0.5e-3 && off < 4e-3) {
      ++table;
      known += here && std::abs(here->p_P.z()) < 1e-3;
    }
    if (off < -0.7e-3 && here) EXPECT_GT(here->p_P.z(), kHeight - 0.03);
  }
  EXPECT_GT(known, 0.99 * table);
}

}  // namespace
}  // namespace impedraw
