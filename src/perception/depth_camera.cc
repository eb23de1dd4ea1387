#include "impedraw/perception/depth_camera.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numbers>
#include <thread>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"
#include "impedraw/common/seeded_normals.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

double disturbed(double depth, const DepthNoise& noise, std::uint64_t seed, std::uint64_t pixel) {
  if (noise.sigma_at_1m > 0.0)
    depth += noise.sigma_at_1m * depth * depth * counted_normal(seed, pixel);
  return depth > 0.0 && std::isfinite(depth) ? depth : std::numeric_limits<double>::quiet_NaN();
}

void validate(const DepthNoise& noise) {
  require_in_range("noise", DepthNoise::Limits::sigma_at_1m, noise.sigma_at_1m);
}

}  // namespace

double DepthCamera::focal_length() const {
  return 0.5 * height / std::tan(fov_y_deg * std::numbers::pi / 360.0);
}

Vector3d DepthCamera::direction_C(int i, int j) const {
  const double f = focal_length();
  return {(i + 0.5 - 0.5 * width) / f, (j + 0.5 - 0.5 * height) / f, 1.0};
}

void validate(const DepthCamera& camera) {
  using Limits = DepthCamera::Limits;
  require_in_range("camera", Limits::width, camera.width);
  require_in_range("camera", Limits::height, camera.height);
  require_in_range("camera", Limits::fov_y, camera.fov_y_deg);
  if (!camera.X_WC.p.allFinite() || !camera.X_WC.R.allFinite())
    throw InputError("depth camera: its pose X_WC must be finite");
}

Pose look_at(const Vector3d& eye_W, const Vector3d& target_W) {
  const Vector3d sight = target_W - eye_W;
  if (!sight.allFinite() || sight.norm() < 1e-9) {
    throw InputError(
        fmt::format("depth camera: eye ({}, {}, {}) and target must be finite and apart", eye_W.x(),
                    eye_W.y(), eye_W.z()));
  }
  const Vector3d z = sight.normalized();
  const Vector3d up = std::abs(z.z()) < 1.0 - 1e-9 ? Vector3d::UnitZ() : Vector3d::UnitX();
  const Vector3d x = z.cross(up).normalized();
  Pose X_WC;
  X_WC.p = eye_W;
  X_WC.R << x, z.cross(x), z;
  return X_WC;
}

std::vector<DepthCamera> standard_cameras() {
  std::vector<DepthCamera> cameras(3);
  for (int c = 0; c < 3; ++c) {
    const double azimuth = c * 2.0 * std::numbers::pi / 3.0;
    cameras[c].X_WC =
        look_at({0.60 + 0.5 * std::cos(azimuth), 0.5 * std::sin(azimuth), 0.90}, {0.60, 0.0, 0.10});
  }
  return cameras;
}

DepthNoise realistic_depth_noise() { return {.sigma_at_1m = 0.001}; }

PixelBox pixels_of(const DepthCamera& camera, const Eigen::AlignedBox3d& box, const Pose& X_WB) {
  constexpr double kLeastDepth = 1e-3;  // [m]
  const PixelBox all{0, 0, camera.width, camera.height};
  if (box.isEmpty()) return {};
  const double f = camera.focal_length();
  Eigen::AlignedBox2d seen;
  const Pose X_CW = camera.X_WC.inverse();
  for (int k = 0; k < 8; ++k) {
    const auto corner = static_cast<Eigen::AlignedBox3d::CornerType>(k);
    const Vector3d p = X_CW * (X_WB * box.corner(corner));
    if (!(p.z() > kLeastDepth)) return all;
    seen.extend(Eigen::Vector2d(f * p.x() / p.z() + 0.5 * camera.width,
                                f * p.y() / p.z() + 0.5 * camera.height));
  }
  // Pixel i reaches from i to i + 1. Rounding asks for one more at each side.
  const auto pixel = [](double x, int most) {
    return static_cast<int>(std::clamp(x, 0.0, static_cast<double>(most)));
  };
  return {pixel(std::floor(seen.min().x()) - 1.0, camera.width),
          pixel(std::floor(seen.min().y()) - 1.0, camera.height),
          pixel(std::ceil(seen.max().x()) + 1.0, camera.width),
          pixel(std::ceil(seen.max().y()) + 1.0, camera.height)};
}

namespace {

constexpr int kBatch = 64;  // rays cast at a time

void render_row(const DepthCamera& camera, const CastRays& cast_rays, const DepthNoise& noise,
                std::uint64_t seed, int j, int left, int right, DepthImage* image) {
  std::array<Vector3d, kBatch> directions;
  std::array<double, kBatch> lengths, distances;
  const double f = camera.focal_length();
  const double y = (j + 0.5 - 0.5 * camera.height) / f;
  for (int first = left; first < right; first += kBatch) {
    const int n = std::min(kBatch, right - first);
    for (int k = 0; k < n; ++k) {
      const Vector3d d_C((first + k + 0.5 - 0.5 * camera.width) / f, y, 1.0);
      lengths[k] = d_C.norm();
      directions[k] = camera.X_WC.R * (d_C / lengths[k]);
    }
    const auto count = static_cast<std::size_t>(n);
    cast_rays(camera.X_WC.p, {directions.data(), count}, {distances.data(), count});
    for (int k = 0; k < n; ++k) {
      if (!(distances[k] > 0.0) || !std::isfinite(distances[k])) continue;
      const std::size_t pixel = static_cast<std::size_t>(j) * camera.width + first + k;
      image->depth[pixel] = disturbed(distances[k] / lengths[k], noise, seed, pixel);
    }
  }
}

void clear(const DepthCamera& camera, DepthImage* image) {
  image->width = camera.width;
  image->height = camera.height;
  image->depth.assign(static_cast<std::size_t>(camera.width) * camera.height,
                      std::numeric_limits<double>::quiet_NaN());
}

}  // namespace

void render_depth(const DepthCamera& camera, const CastRays& cast_rays, const DepthNoise& noise,
                  std::uint64_t seed, const PixelBox& part, DepthImage* image) {
  clear(camera, image);
  for (int j = std::max(0, part.top); j < std::min(part.bottom, camera.height); ++j)
    render_row(camera, cast_rays, noise, seed, j, std::max(0, part.left),
               std::min(part.right, camera.width), image);
}

DepthImage render_depth(const DepthCamera& camera, const CastRays& cast_rays,
                        const DepthNoise& noise, std::uint64_t seed, int threads) {
  validate(camera);
  validate(noise);
  DepthImage image;
  clear(camera, &image);
  std::atomic<int> next_row{0};
  const auto render_rows = [&] {
    for (int j = next_row++; j < image.height; j = next_row++)
      render_row(camera, cast_rays, noise, seed, j, 0, camera.width, &image);
  };
  if (threads <= 0) threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  std::vector<std::thread> others;
  for (int t = 1; t < threads; ++t) others.emplace_back(render_rows);
  render_rows();
  for (auto& thread : others) thread.join();
  return image;
}

DepthImage render_depth(const DepthCamera& camera, const CastRay& cast_ray, const DepthNoise& noise,
                        std::uint64_t seed, int threads) {
  const CastRays one_by_one = [&](const Vector3d& origin, std::span<const Vector3d> directions,
                                  std::span<double> distances) {
    for (std::size_t k = 0; k < directions.size(); ++k)
      distances[k] = cast_ray(origin, directions[k]);
  };
  return render_depth(camera, one_by_one, noise, seed, threads);
}

}  // namespace impedraw
