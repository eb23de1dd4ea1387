// Estimates the present joint positions and velocities from position readings that are quantised,
// noisy and late, with the arm's dynamics as the model.
//
// Model     a_k = M⁻¹ (τ_k + Jᵀ F_ext − C v̂ − g) + â      over step k, from t_k to t_k+1
//           τ_k: the torque that acted, i.e. commanded torque_delay earlier
// Filter    at the time of the newest reading, D = sensor_delay/Δt steps ago:
//             v⁻ = v̂ + Δt a_k,  q⁻ = q̂ + Δt (v̂ + v⁻)/2,  e = q_read − q⁻
//             q̂ = q⁻ + (1 − θ³) e,  v̂ = v⁻ + 1.5 (1 − θ²)(1 − θ) e/Δt,  â ← â + (1 − θ)³ e/Δt²
//           θ = exp(−bandwidth Δt): three poles at the bandwidth
// Forecast  from there to now through the model of the D steps since
// Gives     q̂, v̂ without lag in a motion that the model explains, constant â included. The rest,
//           such as the onset of dry friction, is followed with the filter's bandwidth.
//           A reading's white noise σ reaches v̂ with about 2 σ √(bandwidth³ Δt).
// Noise     σ of each joint's readings is measured: the third difference of positions has the
//           variance 20 σ², and the arm's own motion has next to none in it. Where v̂ would have
//           more than kVelocityNoise of it, the joint's filter has a lower bandwidth, at least
//           least_bandwidth. A drop lasts for seconds after the noise.
//
// â [rad/s²] stands for wrong masses and friction. The reading of the joints' velocity is not used:
// it adds nothing to positions of the same encoder.
// Requires  one update() and one commanded() per step of dt, readings of constant delay, the arm at
//           rest at the first of them, M symmetric positive definite.
// Source    critically damped g-h-k filter: Brookner, "Tracking and Kalman Filtering Made Easy",
//           1998, section 1.3.
#pragma once

#include <array>

#include "impedraw/common/range.h"
#include "impedraw/control/operational_space.h"

namespace impedraw {

struct JointStateEstimatorSettings {
  double dt = 1e-3;           // step, at least 1 ms and less than 1/bandwidth [s]
  double bandwidth = 300.0;   // of the filter [rad/s]; below 1/dt
  double sensor_delay = 0.0;  // age of a reading when passed in, rounded to steps [s]
  double torque_delay = 0.0;  // from commanding a torque until it acts, rounded to steps [s]
  // Noise of the readings lowers the bandwidth to this at the most; at or above bandwidth: not at
  // all [rad/s].
  double least_bandwidth = 150.0;

  static constexpr Range kBandwidth{1.0, 900.0}, kDelay{0.0, 0.03};  // [rad/s], [s]

  void validate() const;  // throws InputError naming the setting and what is valid
};

class JointStateEstimator {
 public:
  static constexpr int kMaxDelaySteps = 32;
  static constexpr double kVelocityNoise = 2.5e-3;  // standard deviation that v̂ may have [rad/s]

  // Throws InputError naming the setting, its value and what would be valid.
  JointStateEstimator(const JointStateEstimatorSettings& settings, int joints);

  // Advances by `steps` steps of dt since the last call, and corrects with the newest position
  // reading. More than one step: the last torque was held. A reading that is not finite is ignored.
  // Allocates nothing.
  void update(const JointVector& q_read, int steps = 1) noexcept;
  // Advances without a reading.
  void coast(int steps = 1) noexcept;
  // At the end of a step: the arm's terms at q(), v(), the newest F_ext at E in W [N, Nm], and the
  // commanded torque after all limits [Nm]. `factored`: where these terms' M is factored already.
  void commanded(const ArmTerms& arm, const Vector6& F_ext, const JointVector& tau,
                 const OperationalSpace* factored = nullptr) noexcept;

  const JointVector& q() const { return q_now_; }  // [rad]
  const JointVector& v() const { return v_now_; }  // [rad/s]

  // Standard deviation of the readings' noise, as measured, per joint [rad]. Of a rounded position
  // in motion it is about quantum/√12.
  JointVector noise() const { return noise_variance_.cwiseSqrt(); }
  // The lowest of any joint's filter at present [rad/s].
  double bandwidth() const { return lowest_bandwidth_; }

  // Lag of v to what the model does not explain, for stability checks, without noise:
  // sensor_delay + 1/bandwidth [s].
  double lag() const { return settings_.sensor_delay + 1.0 / settings_.bandwidth; }

  // Forgets everything. The next reading is taken as a state of rest.
  void reset() noexcept { started_ = false; }

 private:
  void advance() noexcept;
  void forecast() noexcept;
  void measure_noise(const JointVector& q_read) noexcept;
  void set_gains(int joint, double bandwidth) noexcept;

  JointStateEstimatorSettings settings_;
  int sensor_steps_, torque_steps_;
  JointVector gain_q_, gain_v_, gain_a_;
  double lowest_bandwidth_;
  // Readings in a row, their differences of order 0 to 2, and the squares of those of order 3.
  int in_a_row_ = 0, squared_ = 0;
  JointVector differences_[3], squares_, noise_variance_;
  bool started_ = false;
  long step_ = 0;          // steps advanced
  JointVector q_, v_, a_;  // q̂, v̂, â at the time of the newest reading
  JointVector q_now_, v_now_;
  JointVector modelled_;  // of the last command, without â [rad/s²]
  std::array<JointVector, kMaxDelaySteps + 1> accelerations_;  // ring: of step k at k mod size
  std::array<JointVector, kMaxDelaySteps + 1> torques_;        // the same
};

}  // namespace impedraw
