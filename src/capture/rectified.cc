#include "impedraw/capture/rectified.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

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

}  // namespace impedraw
