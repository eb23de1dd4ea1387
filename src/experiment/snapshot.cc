#include "impedraw/experiment/snapshot.h"

#include <algorithm>
#include <cstdint>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "impedraw/capture/capture_cloud.h"
#include "impedraw/capture/found_canvas.h"
#include "impedraw/common/seeded_normals.h"
#include "impedraw/perception/patch_size.h"

namespace impedraw {

DepthCamera true_camera(const DepthCamera& believed, const CameraErrors& errors,
                        std::uint64_t seed) {
  SeededNormals normals(~seed);
  const auto direction = [&normals] {
    const double x = normals.next(), y = normals.next(), z = normals.next();
    return Eigen::Vector3d(x, y, z).normalized();
  };
  DepthCamera camera = believed;
  camera.X_WC.p += errors.shift * direction();
  const Eigen::Vector3d axis = direction();
  if (errors.turn_deg != 0.0)
    camera.X_WC.R =
        Eigen::AngleAxisd(errors.turn_deg * std::numbers::pi / 180.0, axis) * camera.X_WC.R;
  return camera;
}

// Pixels of all cameras together: 24 bytes a pixel and more, until the cloud is thinned.
constexpr double most_pixels = 7e7;

std::uint64_t camera_seed(const Scenario& scenario, std::size_t camera) {
  return static_cast<std::uint64_t>(scenario.seed) * 1000 + camera;
}

namespace {

std::vector<Capsule> shapes_of(ArmModel& arm, const JointVector& q) {
  std::vector<Capsule> body;
  for (const BodyCapsule& c : arm.body_capsules(q)) body.push_back({c.a_W, c.b_W, c.radius});
  return body;
}

JointVector exposure_joints(const ArmModel& arm, const std::vector<double>& joints) {
  if (static_cast<int>(joints.size()) != arm.joints())
    throw InputError(
        fmt::format("'joints' has {} numbers, the arm {} joints", joints.size(), arm.joints()));
  return Eigen::Map<const Eigen::VectorXd>(joints.data(), arm.joints());
}

CaptureCloud points_of_capture(const PerceptionSettings& p, const CloudSettings& settings,
                               ArmModel& arm) {
  if (p.capture.empty())
    throw InputError(
        "perception.capture is empty; perception.source capture needs a folder with "
        "capture.json");
  const auto tip = [&](const std::vector<double>& q) {
    return arm.tip_pose(exposure_joints(arm, q));
  };
  const auto shapes = [&](const std::vector<double>& q) {
    return shapes_of(arm, exposure_joints(arm, q));
  };
  return cloud_of(read_capture(p.capture, tip), settings, shapes, p.align);
}

CaptureCloud points_of_file(const PerceptionSettings& p, const CloudSettings& settings) {
  if (p.cloud.empty())
    throw InputError(
        "perception.cloud is empty; perception.source cloud needs a .ply, .pcd or .xyz file");
  if (p.viewpoint.size() % 3 != 0)
    throw InputError(
        fmt::format("perception.viewpoint has {} numbers; valid are three for each viewpoint, or "
                    "none",
                    p.viewpoint.size()));
  std::vector<Eigen::Vector3d> viewpoints;
  for (std::size_t i = 0; i < p.viewpoint.size(); i += 3)
    viewpoints.emplace_back(p.viewpoint[i], p.viewpoint[i + 1], p.viewpoint[i + 2]);
  return cloud_of(read_cloud_file(p.cloud), p.cloud.string(), viewpoints, settings);
}

PointCloud points_of_cameras(const Scenario& s, const CloudSettings& settings, const Canvas& canvas,
                             const World& world, ArmModel& arm, const JointVector& q) {
  const PerceptionSettings& p = s.perception;
  if (p.cameras.empty())
    throw InputError(
        "perception.cameras is empty; give at least one camera, or perception.enabled: false");
  std::int64_t pixels = 0;
  for (const CameraSettings& c : p.cameras) pixels += static_cast<std::int64_t>(c.width) * c.height;
  if (pixels > most_pixels)
    throw InputError(
        fmt::format("perception.cameras have {:.0f} million pixels together, allowed "
                    "are at most {:.0f} million",
                    1e-6 * static_cast<double>(pixels), 1e-6 * most_pixels));
  PosedBody posed;
  world.copy_body(&posed);
  const CastRays cast = [&](const Eigen::Vector3d& origin,
                            std::span<const Eigen::Vector3d> directions,
                            std::span<double> distances) {
    canvas.rays(origin, directions, distances);
    posed.cover(origin, directions, distances, PosedBody::Rays::all);
  };
  std::vector<DepthCamera> cameras;
  std::vector<DepthImage> images;
  for (std::size_t i = 0; i < p.cameras.size(); ++i) {
    const CameraSettings& c = p.cameras[i];
    cameras.push_back({c.width, c.height, c.fov_y_deg, look_at(c.p_WC, c.target_W)});
    const std::uint64_t seed = camera_seed(s, i);
    images.push_back(
        render_depth(true_camera(cameras.back(), p.errors, seed), cast, p.noise, seed));
    if (p.errors.depth_scale != 0.0)
      for (double& depth : images.back().depth) depth *= 1.0 + p.errors.depth_scale;
  }
  return back_project(images, cameras, settings, shapes_of(arm, q));
}

CloudSettings cloud_settings(const PerceptionSettings& p) {
  CloudSettings settings;
  settings.voxel = p.voxel;
  settings.self_padding = p.self_padding;
  settings.region = Eigen::AlignedBox3d(p.region_lower, p.region_upper);
  return settings;
}

// `where`: what fills which box, for the error.
SurfaceEstimator estimator_of(const PointCloud& seen, const PerceptionSettings& p,
                              const std::string& where) {
  PointCloud cloud = thin(seen, p.voxel);
  if (cloud.points.size() < static_cast<std::size_t>(p.normals.k))
    throw InputError(fmt::format(
        "the cameras see {} points of the canvas within perception.region ({:.2f} to {:.2f}, "
        "{:.2f} to {:.2f}, {:.2f} to {:.2f} m); at least {} are needed{}",
        cloud.points.size(), p.region_lower.x(), p.region_upper.x(), p.region_lower.y(),
        p.region_upper.y(), p.region_lower.z(), p.region_upper.z(), p.normals.k, where));
  FinerClouds finer;
  if (p.adapt && p.voxel > 0.0)
    for (const double share : {0.5, 0.25}) finer.push_back(thin(seen, share * p.voxel));
  return SurfaceEstimator(std::move(cloud), p.normals, std::move(finer));
}

}  // namespace

Snapshot take_snapshot(const Scenario& s, const Canvas& canvas, const World& world, ArmModel& arm,
                       const JointVector& q) {
  const Eigen::AlignedBox3d box = canvas.bounds();
  return {
      estimator_of(points_of_cameras(s, cloud_settings(s.perception), canvas, world, arm, q),
                   s.perception,
                   fmt::format("; the canvas fills ({:.2f} to {:.2f}, {:.2f} to {:.2f}, {:.2f} to "
                               "{:.2f} m)",
                               box.min().x(), box.max().x(), box.min().y(), box.max().y(),
                               box.min().z(), box.max().z())),
      {}};
}

Snapshot read_snapshot(const Scenario& s, const Pose& X_WP, bool placed, ArmModel& arm,
                       std::vector<std::string>* notes) {
  const PerceptionSettings& p = s.perception;
  CaptureCloud read = p.source == PerceptionSource::capture
                          ? points_of_capture(p, cloud_settings(p), arm)
                          : points_of_file(p, cloud_settings(p));
  notes->insert(notes->end(), read.notes.begin(), read.notes.end());
  FoundCanvas found{std::move(read.cloud), {}, {}};
  if (p.find_canvas) {
    const PlacementSettings& at = s.drawing.placement;
    const double width = 1e-3 * std::max(at.width_mm.value_or(0), at.height_mm.value_or(0));
    found = find_canvas(found.canvas,
                        {X_WP, at.centre_m, width > 0.0 ? 0.5 * width : at.fit_radius_m, placed},
                        read.views);
    notes->insert(notes->end(), found.notes.begin(), found.notes.end());
  }
  PerceptionSettings used = p;
  if (p.adapt && !found.canvas.points.empty())
    used.normals.k = calm_patch(thin(found.canvas, p.voxel), p.normals);
  if (used.normals.k > p.normals.k)
    notes->push_back(
        fmt::format("the points are noisy: a normal is fitted to the {} nearest ones, not to {} "
                    "(perception.adapt=false keeps perception.normals.k)",
                    used.normals.k, p.normals.k));
  return {estimator_of(found.canvas, used, ""), thin(found.beside, p.voxel)};
}

}  // namespace impedraw
