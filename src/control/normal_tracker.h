// Tracks the sampled surface normal: a unit vector and its angular velocity, without lag while the
// normal turns at a constant rate. The result gives the desired pen axis.
//
// Law   ω ← ω + ω̇_plan Δt
//       n ← exp([ω Δt + α ε]×) n      ε: the smallest rotation that takes n to the sample
//       ω ← ω + (β/Δt) ε
//       α = 1 − r², β = (1 − r)², r = exp(−bandwidth Δt): critically damped α–β filter
// A lagging filter of the same bandwidth would tilt the pen by 2 ω/bandwidth (0.5° at 50 mm/s in
// the bowl). The remaining error is (ω̇ − ω̇_plan)/bandwidth²: the plan only needs to provide the
// normal's angular acceleration. Requires samples and n of unit length, bandwidth and Δt > 0.
// Source: the α–β filter (Sklansky 1957; critically damped: Benedict and Bordner, IRE Trans.
// Automatic Control 7(4), 1962), on the sphere.
#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace impedraw {

// The smallest rotation vector that takes unit a to unit b [rad]. For exactly opposite vectors the
// axis is an arbitrary perpendicular.
inline Eigen::Vector3d smallest_rotation(const Eigen::Vector3d& a,
                                         const Eigen::Vector3d& b) noexcept {
  const Eigen::Vector3d cross = a.cross(b);
  const double sine = cross.norm(), cosine = a.dot(b);
  if (sine > 1e-12) return (std::atan2(sine, cosine) / sine) * cross;
  if (cosine > 0.0) return cross;  // to first order
  return std::numbers::pi * a.unitOrthogonal();
}

class NormalTracker {
 public:
  NormalTracker(double bandwidth, double dt) : dt_(dt) {
    const double r = std::exp(-bandwidth * dt);
    alpha_ = 1.0 - r * r;
    beta_ = (1.0 - r) * (1.0 - r);
  }  // [rad/s], [s]

  void reset(const Eigen::Vector3d& n_W, const Eigen::Vector3d& w_W) noexcept {
    n_W_ = n_W;
    w_W_ = w_W - n_W * n_W.dot(w_W);
  }
  void update(const Eigen::Vector3d& sample_W, const Eigen::Vector3d& alpha_plan_W) noexcept {
    w_W_ += alpha_plan_W * dt_;
    turn(w_W_ * dt_);
    const Eigen::Vector3d innovation = smallest_rotation(n_W_, sample_W);
    w_W_ += (beta_ / dt_) * innovation;
    turn(alpha_ * innovation);
  }  // [rad/s²]
  void coast() noexcept {
    w_W_ *= 1.0 - alpha_;
    turn(w_W_ * dt_);
  }  // no sample: n keeps turning with ω, which decays with the bandwidth

  const Eigen::Vector3d& n() const { return n_W_; }  // unit
  const Eigen::Vector3d& w() const { return w_W_; }  // [rad/s], perpendicular to n

 private:
  void turn(const Eigen::Vector3d& rotation) noexcept {
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

  double dt_, alpha_, beta_;
  Eigen::Vector3d n_W_ = Eigen::Vector3d::UnitZ(), w_W_ = Eigen::Vector3d::Zero();
};

}  // namespace impedraw
