// A level sheet with noise of a known size.
#include "impedraw/perception/patch_size.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "impedraw/common/seeded_normals.h"

namespace impedraw {
namespace {

// On a grid of 4 mm.
PointCloud sheet(double noise) {
  PointCloud cloud;
  cloud.eyes = {{0.0, 0.0, 1.0}};
  SeededNormals random(5);
  for (double x = -0.15; x < 0.15; x += 0.004)
    for (double y = -0.15; y < 0.15; y += 0.004)
      cloud.points.emplace_back(x, y, noise * random.next());
  cloud.camera.assign(cloud.points.size(), 0);
  return cloud;
}

TEST(PatchSize, NoiseAsksForMorePoints) {
  const NormalSettings settings;
  EXPECT_EQ(calm_patch(sheet(1e-5), settings), settings.k);
  // k points on a grid fill a circle: r = spacing √(k / π), and the fit leaves most of the noise.
  const double noise = 0.2e-3;
  const double error = 4.0 * noise * std::sqrt(std::numbers::pi) / (settings.k * 0.004);
  const int k = calm_patch(sheet(noise), settings);
  EXPECT_NEAR(k, settings.k * error / kCalmNormal, 0.25 * k);
  EXPECT_EQ(calm_patch(sheet(3e-3), settings), kMostNeighbours);
}

TEST(PatchSize, AWishForMoreStays) {
  NormalSettings settings;
  settings.k = 120;
  EXPECT_EQ(calm_patch(sheet(1e-4), settings), 120);
}

TEST(PatchSize, AFewPointsAreNotJudged) {
  PointCloud cloud = sheet(1e-3);
  cloud.points.resize(20);
  cloud.camera.resize(20);
  EXPECT_EQ(calm_patch(cloud, NormalSettings{}), NormalSettings{}.k);
}

}  // namespace
}  // namespace impedraw
