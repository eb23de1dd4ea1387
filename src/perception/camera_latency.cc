#include "impedraw/perception/camera_latency.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

namespace impedraw {

namespace {

using Eigen::Vector3d;

constexpr double kGridStep = 1e-2;    // [s]
constexpr double kDifference = 1e-4;  // of the motion's velocity [s]
constexpr int kSteps = 50;
constexpr double kSettledStep = 1e-7;  // [s]

// Sum of squares at δ, with the best offset.
double squares(std::span<const StampedPoint> seen, const std::function<Vector3d(double)>& motion,
               double delta, Vector3d* offset) {
  const auto n = static_cast<double>(seen.size());
  offset->setZero();
  for (const StampedPoint& s : seen) *offset += (s.p_W - motion(s.stamp - delta)) / n;
  double sum = 0.0;
  for (const StampedPoint& s : seen)
    sum += (s.p_W - motion(s.stamp - delta) - *offset).squaredNorm();
  return sum;
}

}  // namespace

CameraLatency find_camera_latency(std::span<const StampedPoint> seen,
                                  const std::function<Vector3d(double time)>& motion) {
  const auto n = static_cast<double>(seen.size());
  if (seen.size() < static_cast<std::size_t>(kFewestFrames))
    throw std::runtime_error(fmt::format(
        "{} frames with a pose of the canvas; at least {} are needed to find the cameras' latency",
        seen.size(), kFewestFrames));
  CameraLatency found;
  found.frames = static_cast<int>(seen.size());
  Vector3d offset;
  double delta = 0.0, least = std::numeric_limits<double>::infinity();
  const int grid = static_cast<int>(std::ceil(kMostStampError / kGridStep)) + 2;
  for (int k = -grid; k <= grid; ++k)
    if (const double sum = squares(seen, motion, k * kGridStep, &offset); sum < least)
      least = sum, delta = k * kGridStep;
  double information = 0.0;
  for (int step = 0; step < kSteps; ++step) {
    squares(seen, motion, delta, &offset);
    // The residual grows by v − v̄ with δ: the offset takes the mean velocity.
    Vector3d mean = Vector3d::Zero();
    const auto velocity = [&](double t) {
      return Vector3d((motion(t + kDifference) - motion(t - kDifference)) / (2.0 * kDifference));
    };
    for (const StampedPoint& s : seen) mean += velocity(s.stamp - delta) / n;
    double slope = 0.0;
    information = 0.0;
    for (const StampedPoint& s : seen) {
      const Vector3d v = velocity(s.stamp - delta) - mean;
      slope -= v.dot(s.p_W - motion(s.stamp - delta) - offset);
      information += v.squaredNorm();
    }
    if (!(information > 0.0)) break;
    const double change = std::clamp(slope / information, -kGridStep, kGridStep);
    delta += change;
    if (std::abs(change) < kSettledStep) break;
  }
  const double variance = squares(seen, motion, delta, &offset) / (3.0 * n - 4.0);
  found.noise = std::sqrt(variance);
  found.stamp_error = delta;
  found.stamp_error_deviation = information > 0.0 ? std::sqrt(variance / information)
                                                  : std::numeric_limits<double>::infinity();
  if (!(found.stamp_error_deviation <= kMostStampDeviation))
    throw std::runtime_error(
        "the canvas hardly moves, or what is seen moves otherwise than canvas.motion says: the "
        "frames do not tell the time stamps' error to within 2 ms");
  if (!(std::abs(delta) <= kMostStampError))
    throw std::runtime_error(
        fmt::format("the time stamps would be wrong by {:.3f} s; beyond {:.1f} s the motion is "
                    "taken to be another one",
                    delta, kMostStampError));
  double square = 0.0;
  for (const StampedPoint& s : seen) found.latency += (s.arrival - s.stamp + delta) / n;
  for (const StampedPoint& s : seen)
    square += std::pow(s.arrival - s.stamp + delta - found.latency, 2);
  found.jitter = std::sqrt(square / (n - 1.0));
  found.latency_deviation = std::hypot(found.jitter / std::sqrt(n), found.stamp_error_deviation);
  return found;
}

}  // namespace impedraw
