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

#include <Eigen/Core>

namespace impedraw {

class NormalTracker {
 public:
  NormalTracker(double bandwidth, double dt);  // [rad/s], [s]

  void reset(const Eigen::Vector3d& n_W, const Eigen::Vector3d& w_W) noexcept;
  void update(const Eigen::Vector3d& sample_W,
              const Eigen::Vector3d& alpha_plan_W) noexcept;  // [rad/s²]
  void coast() noexcept;  // no sample: n keeps turning with ω, which decays with the bandwidth

  const Eigen::Vector3d& n() const { return n_W_; }  // unit
  const Eigen::Vector3d& w() const { return w_W_; }  // [rad/s], perpendicular to n

 private:
  void turn(const Eigen::Vector3d& rotation) noexcept;

  double dt_, alpha_, beta_;
  Eigen::Vector3d n_W_ = Eigen::Vector3d::UnitZ(), w_W_ = Eigen::Vector3d::Zero();
};

// The smallest rotation vector that takes unit a to unit b [rad]. For exactly opposite vectors the
// axis is an arbitrary perpendicular.
Eigen::Vector3d smallest_rotation(const Eigen::Vector3d& a, const Eigen::Vector3d& b) noexcept;

}  // namespace impedraw
