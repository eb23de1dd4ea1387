// The snapshot before drawing: the arm stands in the picture, is seen, and is cut from the cloud.
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "impedraw/experiment/prepare.h"

namespace impedraw {
namespace {

Prepared prepared(std::vector<std::string> assignments) {
  DrawOptions options;
  options.scenario = "scenarios/bowl-sine.yaml";
  options.assignments = std::move(assignments);
  return prepare(resolve(options));
}

// Points of the cloud further off the true canvas than depth noise or the voxel grid could put
// them.
int strangers(const Prepared& e) {
  int count = 0;
  for (const Eigen::Vector3d& p : e.belief.perception->cloud().points)
    count += std::abs(e.truth.canvas->closest(p).distance) > 2e-3;
  return count;
}

TEST(Snapshot, SeesTheArmAndCutsItOut) {
  // The box reaches over the whole arm, so that nothing but the self filter keeps it out.
  const std::vector<std::string> wide = {"perception.region_lower=[-1, -1, 0.03]",
                                         "perception.region_upper=[1.5, 1, 2]"};
  const Prepared filtered = prepared(wide);
  const DepthCamera camera{640, 480, 60.0, look_at({1.1, 0.0, 0.9}, {0.6, 0.0, 0.1})};
  int pixels_of_arm = 0;
  for (int j = 0; j < camera.height; j += 4) {
    for (int i = 0; i < camera.width; i += 4) {
      const Eigen::Vector3d ray = (camera.X_WC.R * camera.direction_C(i, j)).normalized();
      pixels_of_arm += std::isfinite(filtered.truth.world->ray_to_arm(camera.X_WC.p, ray));
    }
  }
  EXPECT_GT(pixels_of_arm, 300) << "the arm stands in the picture";
  EXPECT_GT(filtered.belief.perception->cloud().points.size(), 5000u);
  EXPECT_EQ(strangers(filtered), 0);
}

TEST(Snapshot, TheCloudLiesOnTheCanvas) {
  const Prepared e = prepared({});
  double sum = 0.0;
  for (const Eigen::Vector3d& p : e.belief.perception->cloud().points)
    sum += e.truth.canvas->closest(p).distance;
  EXPECT_NEAR(sum / e.belief.perception->cloud().points.size(), 0.0, 5e-5)
      << "half a pixel off, it would float 0.4 mm";
}

TEST(Snapshot, CamerasOfMorePixelsThanMemoryHoldsAreRefused) {
  std::vector<std::string> huge;
  for (const int camera : {0, 1})
    for (const char* side : {"width", "height"})
      huge.push_back("perception.cameras." + std::to_string(camera) + "." + side + "=8192");
  try {
    prepared(huge);
    FAIL() << "134 million pixels are accepted";
  } catch (const InputError& e) {
    EXPECT_STREQ(e.what(),
                 "perception.cameras have 135 million pixels together, allowed are at most 70 "
                 "million");
  }
}

TEST(Snapshot, RealisticNoiseIsSeenAndStillDrawn) {
  const Prepared e = prepared(
      {"perception.noise.sigma_at_1m=0.001", "perception.voxel=0.006", "perception.normals.k=120"});
  double sum = 0.0, squares = 0.0;
  const auto& points = e.belief.perception->cloud().points;
  for (const Eigen::Vector3d& p : points) {
    const double d = e.truth.canvas->closest(p).distance;
    sum += d;
    squares += d * d;
  }
  const double n = static_cast<double>(points.size()),
               sd = std::sqrt(squares / n - sum * sum / n / n);
  EXPECT_GT(sd, 1e-4);
  EXPECT_LT(sd, 1e-3);
  EXPECT_NEAR(sum / n, 0.0, 1e-4);
}

// A depth that reads too far moves each point along its ray: across the canvas by s (p − c)·n.
// Where cameras see the same place, a point is their mean.
TEST(Snapshot, ADepthScaleMovesThePointsAlongTheirRays) {
  const double scale = 0.004;
  const Prepared e = prepared({"perception.errors.depth_scale=0.004", "preflight.arm=false"});
  const PointCloud& cloud = e.belief.perception->cloud();
  double moved = 0.0, predicted = 0.0;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const SurfacePoint on = e.truth.canvas->closest(cloud.points[i]);
    const Eigen::Vector3d& c = e.scenario.perception.cameras[cloud.camera[i]].p_WC;
    moved += on.distance;
    predicted += scale * (on.p_W - c).dot(on.n_W);
  }
  EXPECT_LT(predicted / cloud.points.size(), -2e-3);
  EXPECT_NEAR(moved / predicted, 1.0, 0.05);
}

// What one camera sees of the bowl, a part of a sphere, is a sphere with its centre moved: by the
// camera's shift, or across the way to the camera by its turn.
Eigen::Vector3d moved_centre(const Experiment& e, int camera) {
  const PointCloud& cloud = e.belief.perception->cloud();
  const CapSettings& bowl = e.scenario.canvas.cap;
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (cloud.camera[i] != camera) continue;
    const Eigen::Vector3d from = cloud.points[i] - bowl.centre, u = from.normalized();
    A += u * u.transpose();
    b += (from.norm() - bowl.radius) * u;
  }
  return A.inverse() * b;
}

TEST(Snapshot, EachCameraStandsOffByItsErrorInADirectionOfItsOwn) {
  const double shift = 2e-3, turn_deg = 0.2;
  const Prepared shifted = prepared({"perception.errors.shift=0.002"}),
                 turned = prepared({"perception.errors.turn=0.2"}), right = prepared({});
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  for (int camera = 0; camera < 3; ++camera) {
    EXPECT_LT(moved_centre(right, camera).norm(), 1e-4);
    const Eigen::Vector3d by_shift = moved_centre(shifted, camera);
    EXPECT_NEAR(by_shift.norm(), shift, 2e-4) << camera;
    EXPECT_GT((by_shift - last).norm(), 1e-4) << "not all alike";
    last = by_shift;
    const Eigen::Vector3d to_centre =
        turned.scenario.canvas.cap.centre - turned.scenario.perception.cameras[camera].p_WC;
    const Eigen::Vector3d by_turn = moved_centre(turned, camera);
    EXPECT_LT(by_turn.norm(), 1.05 * turn_deg * M_PI / 180.0 * to_centre.norm() + 1e-4);
    EXPECT_NEAR(by_turn.normalized().dot(to_centre.normalized()), 0.0, 0.2) << camera;
  }
}

}  // namespace
}  // namespace impedraw
