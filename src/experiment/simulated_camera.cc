#include "impedraw/experiment/simulated_camera.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "impedraw/common/seeded_normals.h"

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

}  // namespace impedraw
