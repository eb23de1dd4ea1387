#include "impedraw/experiment/snapshot.h"

#include <algorithm>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/perception/depth_camera.h"

namespace impedraw {

SurfaceEstimator take_snapshot(const Scenario& s, const Canvas& canvas, const World& world,
                               ArmModel& arm, const JointVector& q) {
  const PerceptionSettings& p = s.perception;
  if (p.cameras.empty())
    throw InputError(
        "perception.cameras is empty; valid are at least one camera, or perception.enabled: false");
  const Eigen::AlignedBox3d box = canvas.bounds();
  const CastRay cast = [&](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    double distance = world.ray_to_arm(origin, direction);
    if (const auto hit = canvas.ray(origin, direction)) distance = std::min(distance, hit->t);
    return distance;
  };
  std::vector<DepthCamera> cameras;
  std::vector<DepthImage> images;
  for (std::size_t i = 0; i < p.cameras.size(); ++i) {
    const CameraSettings& c = p.cameras[i];
    cameras.push_back({c.width, c.height, c.fov_y_deg, look_at(c.p_WC, c.target_W)});
    images.push_back(
        render_depth(cameras.back(), cast, p.noise, static_cast<std::uint64_t>(s.seed) * 1000 + i));
  }
  std::vector<Capsule> body;
  for (const BodyCapsule& c : arm.body_capsules(q)) body.push_back({c.a_W, c.b_W, c.radius});
  CloudSettings settings;
  settings.voxel = p.voxel;
  settings.self_padding = p.self_padding;
  settings.region = Eigen::AlignedBox3d(p.region_lower, p.region_upper);
  const PointCloud seen = back_project(images, cameras, settings, body);
  PointCloud cloud = thin(seen, settings.voxel);
  if (cloud.points.size() < static_cast<std::size_t>(p.normals.k))
    throw InputError(fmt::format(
        "the cameras see {} points of the canvas within perception.region ({:.2f} to {:.2f}, "
        "{:.2f} to {:.2f}, {:.2f} to {:.2f} m); "
        "at least {} are needed; the canvas fills ({:.2f} to {:.2f}, {:.2f} to {:.2f}, {:.2f} to "
        "{:.2f} m)",
        cloud.points.size(), p.region_lower.x(), p.region_upper.x(), p.region_lower.y(),
        p.region_upper.y(), p.region_lower.z(), p.region_upper.z(), p.normals.k, box.min().x(),
        box.max().x(), box.min().y(), box.max().y(), box.min().z(), box.max().z()));
  FinerClouds finer;
  if (p.adapt && settings.voxel > 0.0)
    for (const double share : {0.5, 0.25}) finer.push_back(thin(seen, share * settings.voxel));
  return SurfaceEstimator(std::move(cloud), p.normals, std::move(finer));
}

}  // namespace impedraw
