#include "impedraw/perception/stereo_faults.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "impedraw/common/seeded_normals.h"

namespace impedraw {

namespace {

using Eigen::Vector3d;

constexpr double kFocal = 0.0017, kRadial = 0.0037, kBias = 0.0025;
constexpr double kPrincipal = 0.71 / 554.0;  // of 640 px that see 60° [rad]
constexpr double kDisparityStep = 1.0 / 32.0, kFocalTimesBaseline = 421.0 * 0.05;  // [px], [px m]
constexpr double kCorrelation = 1.5;                                               // [px]
constexpr double kSteep = 3.73, kSteepLost = 0.7, kLost = 0.01;                    // tan 75°
constexpr double kFlyingStep = 0.02, kFlying = 0.7;                                // [m]

// Gaussian noise of unit variance over a box of pixels, smoothed along rows and columns.
class SmoothNoise {
 public:
  SmoothNoise(std::uint64_t seed, const PixelBox& box, int image_width)
      : box_(box), width_(box.right - box.left) {
    constexpr int kReach = 5;
    std::array<double, 2 * kReach + 1> kernel;
    double squares = 0.0;
    for (int k = -kReach; k <= kReach; ++k) {
      const double x = k / kCorrelation;
      kernel.at(k + kReach) = std::exp(-0.5 * x * x);
      squares += std::exp(-x * x);
    }
    const int height = box.bottom - box.top, columns = width_ + 2 * kReach;
    const std::uint64_t stride = static_cast<std::uint64_t>(image_width) + 2 * kReach;
    std::vector<double> white(static_cast<std::size_t>(columns));
    std::vector<double> rows(static_cast<std::size_t>(width_) * (height + 2 * kReach));
    for (int j = 0; j < height + 2 * kReach; ++j) {
      for (int i = 0; i < columns; ++i)
        white[static_cast<std::size_t>(i)] =
            counted_normal(seed, static_cast<std::uint64_t>(box.top + j) * stride +
                                     static_cast<std::uint64_t>(box.left + i));
      for (int i = 0; i < width_; ++i)
        for (std::size_t k = 0; k < kernel.size(); ++k)
          rows[static_cast<std::size_t>(j) * width_ + i] +=
              kernel[k] * white[static_cast<std::size_t>(i) + k];
    }
    values_.resize(static_cast<std::size_t>(width_) * height);
    for (int j = 0; j < height; ++j)
      for (std::size_t k = 0; k < kernel.size(); ++k)
        for (int i = 0; i < width_; ++i)
          values_[static_cast<std::size_t>(j) * width_ + i] +=
              kernel[k] / squares * rows[(static_cast<std::size_t>(j) + k) * width_ + i];
  }

  double at(int i, int j) const {
    return values_[static_cast<std::size_t>(j - box_.top) * width_ + (i - box_.left)];
  }

 private:
  PixelBox box_;
  int width_;
  std::vector<double> values_;
};

}  // namespace

StereoFaults::StereoFaults(double factor, std::uint64_t seed) : factor_(factor) {
  SeededNormals normals(seed ^ 0x73746572656fU);
  focal_ = factor * kFocal * normals.next();
  for (double& c : principal_) c = factor * kPrincipal * normals.next();
  radial_ = factor * kRadial * normals.next();
  bias_ = factor * kBias * normals.next();
}

Vector3d StereoFaults::seen_along(const Vector3d& d_C) const {
  Vector3d d = d_C;
  d.head<2>() *= 1.0 + focal_ + radial_ * d_C.head<2>().squaredNorm();
  d.head<2>() += principal_;
  return d;
}

CastRays StereoFaults::bent(const DepthCamera& camera, const CastRays& cast_rays) const {
  if (!any()) return cast_rays;
  return [this, R_WC = camera.X_WC.R, &cast_rays](const Vector3d& origin,
                                                  std::span<const Vector3d> directions,
                                                  std::span<double> distances) {
    constexpr std::size_t kBatch = 64;
    std::array<Vector3d, kBatch> bent;
    std::array<double, kBatch> longer;
    for (std::size_t first = 0; first < directions.size(); first += kBatch) {
      const std::size_t n = std::min(kBatch, directions.size() - first);
      for (std::size_t k = 0; k < n; ++k) {
        const Vector3d d_C = R_WC.transpose() * directions[first + k],
                       seen = seen_along(d_C / d_C.z()).normalized();
        bent[k] = R_WC * seen;
        longer[k] = seen.z() / d_C.z();  // the depth is that along the bent ray
      }
      cast_rays(origin, {bent.data(), n}, distances.subspan(first, n));
      for (std::size_t k = 0; k < n; ++k) distances[first + k] *= longer[k];
    }
  };
}

Vector3d StereoFaults::found_at(const Vector3d& p_C) const {
  const Vector3d d = p_C / p_C.z();
  Vector3d believed = d;
  for (int i = 0; i < 5; ++i) believed += d - seen_along(believed);
  return (1.0 + bias_) * p_C.z() * believed;
}

void StereoFaults::disturb(double sigma_at_1m, std::uint64_t seed, const PixelBox& part,
                           const DepthCamera& camera, DepthImage* image) const {
  if (!any()) return;
  const int width = image->width, height = image->height;
  const PixelBox box{std::max(0, part.left), std::max(0, part.top), std::min(part.right, width),
                     std::min(part.bottom, height)};
  if (box.left >= box.right || box.top >= box.bottom) return;
  const double quantum = factor_ * kDisparityStep / kFocalTimesBaseline;  // at 1 m [1/m]
  const double f = camera.focal_length();
  const SmoothNoise noise(seed, box, width);
  const std::vector<double> exact = image->depth;
  const auto depth_at = [&](int i, int j) {
    return i < 0 || j < 0 ? std::numeric_limits<double>::quiet_NaN()
                          : exact[static_cast<std::size_t>(j) * width + i];
  };
  for (int j = box.top; j < box.bottom; ++j) {
    for (int i = box.left; i < box.right; ++i) {
      const std::size_t pixel = static_cast<std::size_t>(j) * width + i;
      double& measured = image->depth[pixel];
      double z = exact[pixel];
      if (!std::isfinite(z)) continue;
      const auto chance = [&](std::uint64_t kind) {
        return uniform_of(mixed(mixed(seed + kind) ^ pixel));
      };
      const double left = depth_at(i - 1, j), above = depth_at(i, j - 1);
      const double slope =
          std::hypot(std::isfinite(left) ? z - left : 0.0, std::isfinite(above) ? z - above : 0.0);
      const bool steep = slope > kSteep * z / f;
      const bool flies = std::abs(z - left) > kFlyingStep && chance(1) < factor_ * kFlying;
      if (chance(2) < factor_ * kLost || (steep && !flies && chance(3) < factor_ * kSteepLost)) {
        measured = std::numeric_limits<double>::quiet_NaN();
        continue;
      }
      if (flies) z += chance(4) * (left - z);
      z += bias_ * z + sigma_at_1m * z * z * noise.at(i, j);
      measured = z > 0.0 ? 1.0 / (std::max(1.0, std::round(1.0 / z / quantum)) * quantum)
                         : std::numeric_limits<double>::quiet_NaN();
    }
  }
}

}  // namespace impedraw
