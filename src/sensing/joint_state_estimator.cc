#include "impedraw/sensing/joint_state_estimator.h"

#include <algorithm>
#include <cmath>

#include "impedraw/common/range_check.h"

namespace impedraw {

namespace {

constexpr int kNoiseWindow = 200;  // readings
constexpr double kForget = 0.02;   // share of the noise that is forgotten after a window

}  // namespace

void JointStateEstimatorSettings::validate() const {
  RangeChecks("control.joint_sensing")
      .field("bandwidth", bandwidth, kBandwidth, "rad/s")
      .field("least_bandwidth", least_bandwidth, kBandwidth, "rad/s")
      .field("sensor_delay", sensor_delay, kDelay, "s")
      .field("torque_delay", torque_delay, kDelay, "s");
  require_in_range("joint state estimator: dt", dt, {1e-3, 1.0 / bandwidth, false, true}, "s");
}

JointStateEstimator::JointStateEstimator(const JointStateEstimatorSettings& settings, int joints)
    : settings_((settings.validate(), settings)),
      sensor_steps_(static_cast<int>(std::lround(settings.sensor_delay / settings.dt))),
      torque_steps_(static_cast<int>(std::lround(settings.torque_delay / settings.dt))),
      gain_q_(joints),
      gain_v_(joints),
      gain_a_(joints),
      lowest_bandwidth_(settings.bandwidth),
      squares_(JointVector::Zero(joints)),
      noise_variance_(squares_),
      q_(squares_),
      v_(q_),
      a_(q_),
      q_now_(q_),
      v_now_(q_),
      modelled_(q_) {
  for (int j = 0; j < joints; ++j) set_gains(j, settings.bandwidth);
  for (JointVector& d : differences_) d = q_;
  accelerations_.fill(q_);
  torques_.fill(q_);
}

void JointStateEstimator::set_gains(int joint, double bandwidth) noexcept {
  const double dt = settings_.dt, theta = std::exp(-bandwidth * dt), rest = 1.0 - theta;
  gain_q_[joint] = 1.0 - theta * theta * theta;
  gain_v_[joint] = 1.5 * (1.0 - theta * theta) * rest / dt;
  gain_a_[joint] = rest * rest * rest / (dt * dt);
}

// Measures with a reading one step after the last.
void JointStateEstimator::measure_noise(const JointVector& q_read) noexcept {
  JointVector difference = q_read;
  for (JointVector& last : differences_) {
    const JointVector next = difference - last;
    last = difference;
    difference = next;
  }
  if (++in_a_row_ <= 3) return;
  squares_ += difference.cwiseAbs2();
  if (++squared_ < kNoiseWindow) return;
  lowest_bandwidth_ = settings_.bandwidth;
  for (int j = 0; j < squares_.size(); ++j) {
    noise_variance_[j] =
        std::max(squares_[j] / (20.0 * squared_), (1.0 - kForget) * noise_variance_[j]);
    // 2 σ √(bandwidth³ Δt) = kVelocityNoise
    const double most = std::cbrt(0.25 * kVelocityNoise * kVelocityNoise /
                                  (settings_.dt * std::max(noise_variance_[j], 1e-30)));
    const double bandwidth =
        std::min(settings_.bandwidth, std::max(settings_.least_bandwidth, most));
    set_gains(j, bandwidth);
    lowest_bandwidth_ = std::min(lowest_bandwidth_, bandwidth);
  }
  squares_.setZero();
  squared_ = 0;
}

void JointStateEstimator::update(const JointVector& q_read, int steps) noexcept {
  if (!q_read.allFinite()) return coast(steps);
  if (!started_) {
    q_ = q_now_ = q_read;
    v_.setZero();
    a_.setZero();
    v_now_.setZero();
    accelerations_.fill(v_);
    step_ = 0;
    started_ = true;
    in_a_row_ = 0;
    measure_noise(q_read);
    return;
  }
  for (int i = 0; i < steps; ++i) advance();
  if (steps != 1) in_a_row_ = 0;
  measure_noise(q_read);
  const JointVector e = q_read - q_;
  q_ += gain_q_.cwiseProduct(e);
  v_ += gain_v_.cwiseProduct(e);
  a_ += gain_a_.cwiseProduct(e);
  forecast();
}

void JointStateEstimator::coast(int steps) noexcept {
  if (!started_) return;
  in_a_row_ = 0;
  for (int i = 0; i < steps; ++i) advance();
  forecast();
}

// By one step, through the model of step step_ − sensor_steps_.
void JointStateEstimator::advance() noexcept {
  constexpr int kSize = kMaxDelaySteps + 1;
  accelerations_[step_ % kSize] = modelled_;
  // Before the first command the arm rests.
  const long k = step_ - sensor_steps_;
  JointVector a = a_;
  if (k >= 0) a += accelerations_[k % kSize];
  q_ += settings_.dt * (v_ + (0.5 * settings_.dt) * a);
  v_ += settings_.dt * a;
  ++step_;
}

// Through the steps since the newest reading.
void JointStateEstimator::forecast() noexcept {
  constexpr int kSize = kMaxDelaySteps + 1;
  q_now_ = q_;
  v_now_ = v_;
  for (long k = step_ - sensor_steps_; k < step_; ++k) {
    JointVector a = a_;
    if (k >= 0) a += accelerations_[k % kSize];
    q_now_ += settings_.dt * (v_now_ + (0.5 * settings_.dt) * a);
    v_now_ += settings_.dt * a;
  }
}

void JointStateEstimator::commanded(const ArmTerms& arm, const Vector6& F_ext,
                                    const JointVector& tau,
                                    const OperationalSpace* factored) noexcept {
  constexpr int kSize = kMaxDelaySteps + 1;
  if (step_ == 0) torques_.fill(tau);
  torques_[step_ % kSize] = tau;
  const JointVector& acting = torques_[(step_ + kSize - torque_steps_) % kSize];
  const JointVector excess = acting + arm.J.transpose().lazyProduct(F_ext) - arm.Cv - arm.g;
  OperationalSpace own;
  if (!factored) own.update(arm);
  const JointVector modelled = (factored ? *factored : own).acceleration(excess);
  if (modelled.allFinite()) modelled_ = modelled;
}

}  // namespace impedraw
