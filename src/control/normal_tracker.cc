#include "impedraw/control/normal_tracker.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace impedraw {

Eigen::Vector3d smallest_rotation(const Eigen::Vector3d& a, const Eigen::Vector3d& b) noexcept {
  const Eigen::Vector3d cross = a.cross(b);
  const double sine = cross.norm(), cosine = a.dot(b);
  if (sine > 1e-12) return (std::atan2(sine, cosine) / sine) * cross;
  if (cosine > 0.0) return cross;  // to first order
  return std::numbers::pi * a.unitOrthogonal();
}

NormalTracker::NormalTracker(double bandwidth, double dt) : dt_(dt) {
  const double r = std::exp(-bandwidth * dt);
  alpha_ = 1.0 - r * r;
  beta_ = (1.0 - r) * (1.0 - r);
}

void NormalTracker::reset(const Eigen::Vector3d& n_W, const Eigen::Vector3d& w_W) noexcept {
  n_W_ = n_W;
  w_W_ = w_W - n_W * n_W.dot(w_W);
}

void NormalTracker::update(const Eigen::Vector3d& sample_W,
                           const Eigen::Vector3d& alpha_plan_W) noexcept {
  w_W_ += alpha_plan_W * dt_;
  turn(w_W_ * dt_);
  const Eigen::Vector3d innovation = smallest_rotation(n_W_, sample_W);
  w_W_ += (beta_ / dt_) * innovation;
  turn(alpha_ * innovation);
}

void NormalTracker::coast() noexcept {
  w_W_ *= 1.0 - alpha_;
  turn(w_W_ * dt_);
}

void NormalTracker::turn(const Eigen::Vector3d& rotation) noexcept {
  // Rodrigues' formula: n + sin θ/θ r × n + (1 − cos θ)/θ² r × (r × n), r = rotation, θ = |r|; by
  // series to rounding where θ is small, as it is in nearly every step.
  const double squared = rotation.squaredNorm();
  double along = 1.0 - squared / 6.0 * (1.0 - squared / 20.0 * (1.0 - squared / 42.0));
  double inward = 0.5 - squared / 24.0 * (1.0 - squared / 30.0 * (1.0 - squared / 56.0));
  if (squared > 1e-3) {
    const double angle = std::sqrt(squared);
    along = std::sin(angle) / angle;
    inward = (1.0 - std::cos(angle)) / squared;
  }
  const Eigen::Vector3d across = rotation.cross(n_W_);
  n_W_ += along * across + inward * rotation.cross(across);
  n_W_.normalize();
  w_W_ -= n_W_ * n_W_.dot(w_W_);
}

}  // namespace impedraw
