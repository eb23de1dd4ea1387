#include "impedraw/experiment/snapshot.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "impedraw/capture/capture_cloud.h"
#include "impedraw/capture/found_canvas.h"
#include "impedraw/common/in_parallel.h"
#include "impedraw/common/seeded_normals.h"
#include "impedraw/perception/patch_size.h"
#include "impedraw/perception/rigid_fit.h"
#include "impedraw/perception/wall_sides.h"

namespace impedraw {
namespace {

constexpr double kSkin = 5e-3;  // what is hit this close before a mark is the mark itself [m]
constexpr int kBent = 8;        // a lens moves pixels by less than this [px]

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

}  // namespace

std::uint64_t camera_seed(const Scenario& scenario, std::size_t camera) {
  return static_cast<std::uint64_t>(scenario.seed) * 1000 + camera;
}

SimulatedCamera::SimulatedCamera(const Scenario& s, std::size_t number)
    : SimulatedCamera(s, number, s.perception.cameras[number].width,
                      s.perception.cameras[number].height) {}

SimulatedCamera::SimulatedCamera(const Scenario& s, std::size_t number, int width, int height)
    : seed_(camera_seed(s, number)),
      noise_(s.perception.noise),
      depth_scale_(1.0 + s.perception.errors.depth_scale) {
  const CameraSettings& c = s.perception.cameras[number];
  believed_ = {width, height, c.fov_y_deg, look_at(c.p_WC, c.target_W)};
  actual_ = true_camera(believed_, s.perception.errors, seed_);
  validate(actual_);
  if (s.perception.stereo) faults_ = StereoFaults(1.0, seed_);
}

DepthImage SimulatedCamera::image(const CastRays& cast_rays) const {
  DepthImage image = render_depth(actual_, faults_.bent(actual_, cast_rays),
                                  faults_.any() ? DepthNoise() : noise_, seed_);
  faults_.disturb(noise_.sigma_at_1m, seed_, {0, 0, image.width, image.height}, actual_, &image);
  if (depth_scale_ != 1.0)
    for (double& depth : image.depth) depth *= depth_scale_;
  return image;
}

void SimulatedCamera::render(const CastRays& cast_rays, std::uint64_t seed, const PixelBox& part,
                             DepthImage* image) const {
  render_depth(actual_, faults_.bent(actual_, cast_rays), faults_.any() ? DepthNoise() : noise_,
               seed, part, image);
  faults_.disturb(noise_.sigma_at_1m, seed, part, actual_, image);
  if (depth_scale_ != 1.0)
    for (double& depth : image->depth) depth *= depth_scale_;
}

PixelBox SimulatedCamera::part(const Eigen::AlignedBox3d& box, const Pose& X_WB) const {
  const PixelBox seen = pixels_of(actual_, box, X_WB);
  if (!faults_.any()) return seen;
  return {seen.left - kBent, seen.top - kBent, seen.right + kBent, seen.bottom + kBent};
}

bool SimulatedCamera::sees(const Eigen::Vector3d& p_W, const World& world, const Canvas& canvas,
                           const Pose& X_WK) const noexcept {
  const Eigen::Vector3d p_C = actual_.X_WC.inverse() * p_W;
  if (p_C.z() <= 0.0) return false;
  const double f = actual_.focal_length();
  if (std::abs(p_C.x() / p_C.z()) * f > 0.5 * actual_.width ||
      std::abs(p_C.y() / p_C.z()) * f > 0.5 * actual_.height)
    return false;
  const Eigen::Vector3d way = p_W - actual_.X_WC.p;
  const double distance = way.norm();
  const Eigen::Vector3d direction = way / distance;
  if (world.ray_to_arm(actual_.X_WC.p, direction) < distance - kSkin) return false;
  const auto hit = canvas.ray(X_WK.inverse() * actual_.X_WC.p, X_WK.R.transpose() * direction);
  return !hit || hit->t > distance - kSkin;
}

Eigen::Vector3d SimulatedCamera::found_at(const Eigen::Vector3d& p_W,
                                          std::size_t number) const noexcept {
  const Eigen::Vector3d found =
      faults_.any() ? believed_.X_WC * faults_.found_at(actual_.X_WC.inverse() * p_W)
                    : believed_.X_WC * actual_.X_WC.inverse() * p_W;
  return number < marks_off_.size() ? Eigen::Vector3d(found - marks_off_[number]) : found;
}

// Pixels of all cameras together: 24 bytes a pixel and more, until the cloud is thinned.
constexpr double most_pixels = 7e7;

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
  return cloud_of(read_capture(p.capture, tip, p.frames.enabled), settings, shapes, p.align);
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

CloudSettings cloud_settings(const PerceptionSettings& p) {
  CloudSettings settings;
  settings.voxel = p.voxel;
  settings.self_padding = p.self_padding;
  settings.region = Eigen::AlignedBox3d(p.region_lower, p.region_upper);
  return settings;
}

// The correction of a camera by the marks, which stand where they are known to before anything has
// moved; none where they tell nothing beyond their noise.
CameraCorrection correction_by_marks(const SimulatedCamera& camera, const FiducialSettings& marks,
                                     const World& world, const Canvas& canvas) {
  constexpr int kFrames = 15;                          // which are averaged
  constexpr double kLeast = 5e-5, kBesideLine = 0.02;  // [m]
  constexpr double kSure = 8.0;                        // standard deviations of χ²
  SeededNormals noise(camera.seed() ^ 0x6d61726b73U);
  const double sigma = std::max(kLeast, marks.noise / std::sqrt(double{kFrames}));
  std::vector<Eigen::Vector3d> found, known;
  std::vector<std::size_t> numbers;
  double off = 0.0;  // χ²
  for (std::size_t i = 0; i < marks.points.size(); ++i) {
    const Fiducial& mark = marks.points[i];
    Eigen::Vector3d error;
    for (double& e : error) e = marks.noise / std::sqrt(double{kFrames}) * noise.next();
    if (!camera.sees(mark.p_K, world, canvas, {})) continue;
    found.push_back(camera.found_at(mark.p_K, i) + error);
    known.push_back(mark.p_K);
    numbers.push_back(i);
    off += (found.back() - known.back()).squaredNorm() / (sigma * sigma);
  }
  const double count = 3.0 * static_cast<double>(found.size());
  if (found.size() < 3 || spread_beside_line(known) < kBesideLine ||
      off < count + kSure * std::sqrt(2.0 * count))
    return {};
  CameraCorrection correction{
      fit_rigid(found, known).X_WK,
      std::vector<Eigen::Vector3d>(marks.points.size(), Eigen::Vector3d::Zero())};
  for (std::size_t k = 0; k < found.size(); ++k)
    correction.marks[numbers[k]] = correction.T * found[k] - known[k];
  return correction;
}

// Views of the cameras, as a capture has them.
CaptureCloud as_captured(const std::vector<DepthImage>& images,
                         const std::vector<DepthCamera>& cameras, const CloudSettings& settings,
                         const std::vector<Capsule>& arm, bool aligned) {
  Capture capture;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const DepthCamera& c = cameras[i];
    CapturedView& view = capture.views.emplace_back();
    view.name = fmt::format("camera {}", i + 1);
    view.lens = {c.width,
                 c.height,
                 c.focal_length(),
                 c.focal_length(),
                 0.5 * (c.width - 1),
                 0.5 * (c.height - 1)};
    view.X_WC = c.X_WC;
    view.joints = {0.0};  // where the arm is now
    view.depth = images[i];
  }
  return cloud_of(
      std::move(capture), settings, [&arm](const auto&) { return arm; }, aligned);
}

struct CameraPoints {
  PointCloud cloud;
  std::vector<CameraCorrection> corrections;
};

CameraPoints points_of_cameras(const Scenario& s, const Canvas& canvas, const World& world,
                               ArmModel& arm, const JointVector& q,
                               std::vector<std::string>* notes) {
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
  CameraPoints seen;
  std::vector<DepthCamera> cameras;
  std::vector<DepthImage> images;
  const bool follows = p.frames.enabled && p.canvas_pose == CanvasPoseSource::tracked;
  for (std::size_t i = 0; i < p.cameras.size(); ++i) {
    const SimulatedCamera camera(s, i);
    images.push_back(camera.image(cast));
    CameraCorrection correction;
    if (follows) correction = correction_by_marks(camera, p.fiducials, world, canvas);
    const Pose& T = correction.T;
    cameras.push_back(camera.believed());
    if (!correction.marks.empty()) {
      cameras.back().X_WC = T * cameras.back().X_WC;
      notes->push_back(fmt::format(
          "camera {}: the marks show that it stands {:.2f} mm and {:.3f}° off, and it is put there",
          i + 1, 1e3 * (cameras.back().X_WC.p - camera.believed().X_WC.p).norm(),
          Eigen::AngleAxisd(T.R).angle() * 180.0 / std::numbers::pi));
      seen.corrections.resize(p.cameras.size());
      seen.corrections[i] = std::move(correction);
    }
  }
  if (!p.stereo) {
    seen.cloud = back_project(images, cameras, cloud_settings(p), shapes_of(arm, q));
    return seen;
  }
  CaptureCloud captured = as_captured(images, cameras, cloud_settings(p), shapes_of(arm, q),
                                      p.align && seen.corrections.empty());
  notes->insert(notes->end(), captured.notes.begin(), captured.notes.end());
  seen.cloud = std::move(captured.cloud);
  for (const AlignedView& view : captured.alignment.views) seen.corrections.push_back({view.T, {}});
  return seen;
}

SurfaceEstimator estimator_of(const PointCloud& seen, const PerceptionSettings& p) {
  const int levels = p.adapt && p.voxel > 0.0 ? 3 : 1;
  FinerClouds finer(levels);  // but for the first
  in_parallel(levels, [&](int i) { finer[i] = thin(seen, std::ldexp(p.voxel, -i)); });
  PointCloud cloud = std::move(finer.front());
  finer.erase(finer.begin());
  if (cloud.points.size() < static_cast<std::size_t>(p.normals.k))
    throw InputError(fmt::format(
        "the cameras see {} points of the canvas within perception.region ({:.2f} to {:.2f}, "
        "{:.2f} to {:.2f}, {:.2f} to {:.2f} m); at least {} are needed",
        cloud.points.size(), p.region_lower.x(), p.region_upper.x(), p.region_lower.y(),
        p.region_upper.y(), p.region_lower.z(), p.region_upper.z(), p.normals.k));
  return SurfaceEstimator(std::move(cloud), p.normals, std::move(finer));
}

// A text that says where the simulated canvas lies, and which of the arm's bodies stands there.
std::string place_of(const Canvas& canvas, ArmModel& arm, const JointVector& q, double padding) {
  const Eigen::AlignedBox3d box = canvas.bounds();
  std::string where = fmt::format(
      "; the canvas fills ({:.2f} to {:.2f}, {:.2f} to {:.2f}, {:.2f} to {:.2f} m)", box.min().x(),
      box.max().x(), box.min().y(), box.max().y(), box.min().z(), box.max().z());
  for (const BodyCapsule& body : arm.body_capsules(q))
    if (inside({body.a_W, body.b_W, body.radius}, padding, box.center()))
      where += fmt::format("; {}, whose body is {:.2g} m across, stands there", body.link,
                           2.0 * body.radius);
  return where;
}

// With normals of as many points as the cloud's noise asks for.
PerceptionSettings for_noise(const PerceptionSettings& p, const PointCloud& cloud,
                             std::vector<std::string>* notes) {
  PerceptionSettings used = p;
  if (p.adapt && !cloud.points.empty())
    used.normals.k = calm_patch(thin(cloud, p.voxel), p.normals);
  if (used.normals.k > p.normals.k)
    notes->push_back(
        fmt::format("the points are noisy: a normal is fitted to the {} nearest ones, not to {} "
                    "(perception.adapt=false keeps perception.normals.k)",
                    used.normals.k, p.normals.k));
  return used;
}

}  // namespace

Snapshot take_snapshot(const Scenario& s, const Canvas& canvas, const World& world, ArmModel& arm,
                       const JointVector& q, std::vector<std::string>* notes) {
  CameraPoints seen = points_of_cameras(s, canvas, world, arm, q, notes);
  const PerceptionSettings used =
      s.perception.stereo ? for_noise(s.perception, seen.cloud, notes) : s.perception;
  try {
    return {estimator_of(seen.cloud, used), {}, std::move(seen.corrections)};
  } catch (const InputError& error) {
    throw InputError(error.what() + place_of(canvas, arm, q, s.perception.self_padding));
  }
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
  const std::size_t both_sides = found.canvas.points.size();
  found.canvas = without_far_sides(found.canvas, p.voxel, p.normals);
  if (found.canvas.points.size() < both_sides)
    notes->push_back(
        fmt::format("walls thinner than {:.0f} mm are seen from both sides: {} points of the sides "
                    "that the pen gets to less easily are left out",
                    1e3 * kThinWall * p.voxel, both_sides - found.canvas.points.size()));
  const PerceptionSettings used = for_noise(p, found.canvas, notes);
  Snapshot snapshot{estimator_of(found.canvas, used), thin(found.beside, p.voxel), {}};
  for (const AlignedView& view : read.alignment.views) snapshot.corrections.push_back({view.T, {}});
  return snapshot;
}

}  // namespace impedraw
