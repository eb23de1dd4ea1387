#include "impedraw/capture/lens.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/LU>

namespace impedraw {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// The pixel that looks along (x, y, 1), by fixed-point iteration: distortion is small.
Eigen::Vector2d place_of(const Lens& lens, const Eigen::Vector3d& d_C) {
  constexpr int kIterations = 20;
  constexpr double kReached = 1e-3;  // [px]
  Eigen::Vector2d at(lens.cx + lens.fx * d_C.x(), lens.cy + lens.fy * d_C.y());
  for (int i = 0; i < kIterations; ++i) {
    const auto d = lens.direction_C(at.x(), at.y());
    if (!d) break;
    const Eigen::Vector2d step(lens.fx * (d_C.x() - d->x()), lens.fy * (d_C.y() - d->y()));
    at += step;
    if (step.norm() < kReached) return at;
  }
  return {kNan, kNan};
}

}  // namespace

Rectified::Rectified(const Lens& lens, const Pose& X_WC, int width, int height)
    : seen_width_(lens.width), seen_height_(lens.height) {
  const double half = 0.5 * lens.height / lens.fy;
  camera_ = {width, height, 2.0 * std::atan(half) * 180.0 / std::numbers::pi, X_WC};
  for (int j = 0; j < height; ++j)
    for (int i = 0; i < width; ++i)
      places_.push_back(place_of(lens, camera_.direction_C(i, j)).cast<float>());
}

void Rectified::depths(const DepthImage& seen, DepthImage* rectified) const {
  constexpr double kSteep = 5.67;  // tan 80°: a step between two pixels that one surface explains
  const double pitch = 2.0 * std::tan(camera_.fov_y_deg * std::numbers::pi / 360.0) / seen_height_;
  rectified->width = camera_.width;
  rectified->height = camera_.height;
  rectified->depth.assign(places_.size(), kNan);
  for (std::size_t k = 0; k < places_.size(); ++k) {
    const double u = places_[k].x(), v = places_[k].y();
    if (!(u >= 0.0 && v >= 0.0 && u <= seen_width_ - 1 && v <= seen_height_ - 1)) continue;
    const int i = std::min(static_cast<int>(u), seen_width_ - 2),
              j = std::min(static_cast<int>(v), seen_height_ - 2);
    const double a = u - i, b = v - j;
    const double z[] = {seen.at(i, j), seen.at(i + 1, j), seen.at(i, j + 1), seen.at(i + 1, j + 1)};
    const auto [low, high] = std::minmax_element(std::begin(z), std::end(z));
    const double w = (1 - b) * ((1 - a) / z[0] + a / z[1]) + b * ((1 - a) / z[2] + a / z[3]);
    if (std::isfinite(w) && *high - *low <= 2.0 * kSteep * pitch * *low)
      rectified->depth[k] = 1.0 / w;
  }
}

namespace {

using Eigen::Vector2d;

struct Distorted {
  Vector2d value;
  Eigen::Matrix2d derivative;
};

// D(a) and ∂D/∂a.
Distorted distort(const std::array<double, 5>& c, const Vector2d& a) {
  const auto& [k1, k2, p1, p2, k3] = c;
  const double x = a.x(), y = a.y(), r2 = a.squaredNorm();
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double slope = k1 + r2 * (2 * k2 + 3 * r2 * k3);  // of `radial` by r²
  Distorted d;
  d.value = {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
             y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
  d.derivative(0, 0) = radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x;
  d.derivative(1, 1) = radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x;
  d.derivative(0, 1) = d.derivative(1, 0) = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y;
  return d;
}

}  // namespace

std::optional<Eigen::Vector3d> Lens::direction_C(double i, double j) const {
  constexpr int kIterations = 30;
  constexpr double kTolerance = 1e-12;
  const Vector2d seen((i - cx) / fx, (j - cy) / fy);
  if (model == Model::none) return Eigen::Vector3d(seen.x(), seen.y(), 1);
  if (model == Model::inverse_brown_conrady) {
    const Vector2d ideal = distort(k, seen).value;
    return Eigen::Vector3d(ideal.x(), ideal.y(), 1);
  }
  Vector2d ideal = seen;
  for (int step = 0; step < kIterations; ++step) {
    const Distorted d = distort(k, ideal);
    const Vector2d error = d.value - seen;
    // Beyond the fold of the polynomial, a point of the image belongs to no ray.
    if (!error.allFinite() || d.derivative.determinant() <= 0) return std::nullopt;
    if (error.norm() < kTolerance) return Eigen::Vector3d(ideal.x(), ideal.y(), 1);
    ideal -= d.derivative.inverse() * error;
  }
  return std::nullopt;
}

}  // namespace impedraw
