// The snapshot before drawing: the arm stands in the picture, is seen, and is cut from the cloud.
#include <cmath>

#include <gtest/gtest.h>

#include "impedraw/experiment/draw_options.h"
#include "impedraw/experiment/experiment.h"

namespace impedraw {
namespace {

Experiment prepared(std::vector<std::string> assignments) {
  DrawOptions options;
  options.scenario = "scenarios/bowl-sine.yaml";
  options.assignments = std::move(assignments);
  return prepare(resolve(options));
}

// Points of the cloud further off the true canvas than depth noise or the voxel grid could put
// them.
int strangers(const Experiment& e) {
  int count = 0;
  for (const Eigen::Vector3d& p : e.scene.perception->cloud().points)
    count += std::abs(e.scene.canvas->closest(p).distance) > 2e-3;
  return count;
}

TEST(Snapshot, SeesTheArmAndCutsItOut) {
  // The box reaches over the whole arm, so that nothing but the self filter keeps it out.
  const std::vector<std::string> wide = {"perception.region_lower=[-1, -1, 0.03]",
                                         "perception.region_upper=[1.5, 1, 2]"};
  const Experiment filtered = prepared(wide);
  const DepthCamera camera{640, 480, 60.0, look_at({1.1, 0.0, 0.9}, {0.6, 0.0, 0.1})};
  int pixels_of_arm = 0;
  for (int j = 0; j < camera.height; j += 4) {
    for (int i = 0; i < camera.width; i += 4) {
      const Eigen::Vector3d ray = (camera.X_WC.R * camera.direction_C(i, j)).normalized();
      pixels_of_arm += std::isfinite(filtered.scene.world->ray_to_arm(camera.X_WC.p, ray));
    }
  }
  EXPECT_GT(pixels_of_arm, 300) << "the arm stands in the picture";
  EXPECT_GT(filtered.scene.perception->cloud().points.size(), 5000u);
  EXPECT_EQ(strangers(filtered), 0);
}

TEST(Snapshot, TheCloudLiesOnTheCanvas) {
  const Experiment e = prepared({});
  double sum = 0.0;
  for (const Eigen::Vector3d& p : e.scene.perception->cloud().points)
    sum += e.scene.canvas->closest(p).distance;
  EXPECT_NEAR(sum / e.scene.perception->cloud().points.size(), 0.0, 5e-5)
      << "half a pixel off, it would float 0.4 mm";
}

TEST(Snapshot, RealisticNoiseIsSeenAndStillDrawn) {
  const Experiment e = prepared(
      {"perception.noise.sigma_at_1m=0.001", "perception.voxel=0.006", "perception.normals.k=120"});
  double sum = 0.0, squares = 0.0;
  const auto& points = e.scene.perception->cloud().points;
  for (const Eigen::Vector3d& p : points) {
    const double d = e.scene.canvas->closest(p).distance;
    sum += d;
    squares += d * d;
  }
  const double n = static_cast<double>(points.size()),
               sd = std::sqrt(squares / n - sum * sum / n / n);
  EXPECT_GT(sd, 1e-4);
  EXPECT_LT(sd, 1e-3);
  EXPECT_NEAR(sum / n, 0.0, 1e-4);
}

}  // namespace
}  // namespace impedraw
