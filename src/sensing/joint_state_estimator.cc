#include "impedraw/sensing/joint_state_estimator.h"

#include <cmath>

#include "impedraw/common/range_check.h"

namespace impedraw {

namespace {

// M⁻¹ b by Cholesky's factorisation, in plain loops: for so few joints half the time of Eigen's.
JointVector solve(const JointMatrix& M, const JointVector& b) noexcept {
  const Eigen::Index n = b.size();
  double L[kMaxJoints][kMaxJoints], x[kMaxJoints];
  for (Eigen::Index i = 0; i < n; ++i) {
    double y = b[i];
    for (Eigen::Index j = 0; j <= i; ++j) {
      double sum = M(i, j);
      for (Eigen::Index k = 0; k < j; ++k) sum -= L[i][k] * L[j][k];
      L[i][j] = j < i ? sum * L[j][j] : 1.0 / std::sqrt(sum);  // the diagonal's reciprocal
      if (j < i) y -= L[i][j] * x[j];
    }
    x[i] = y * L[i][i];
  }
  JointVector out(n);
  for (Eigen::Index i = n; i-- > 0;) {
    double y = x[i];
    for (Eigen::Index k = i + 1; k < n; ++k) y -= L[k][i] * out[k];
    out[i] = y * L[i][i];
  }
  return out;
}

}  // namespace

void JointStateEstimatorSettings::validate() const {
  const char* group = "control.joint_sensing";
  require_in_range(group, Limits::bandwidth, bandwidth);
  require_in_range("joint state estimator: dt", dt, {1e-3, 1.0 / bandwidth, false, true}, "s");
  require_in_range(group, Limits::sensor_delay, sensor_delay);
  require_in_range(group, Limits::torque_delay, torque_delay);
}

JointStateEstimator::JointStateEstimator(const JointStateEstimatorSettings& settings, int joints)
    : settings_((settings.validate(), settings)),
      sensor_steps_(static_cast<int>(std::lround(settings.sensor_delay / settings.dt))),
      torque_steps_(static_cast<int>(std::lround(settings.torque_delay / settings.dt))),
      q_(JointVector::Zero(joints)),
      v_(q_),
      a_(q_),
      q_now_(q_),
      v_now_(q_),
      modelled_(q_) {
  const double theta = std::exp(-settings.bandwidth * settings.dt), rest = 1.0 - theta;
  gain_q_ = 1.0 - theta * theta * theta;
  gain_v_ = 1.5 * (1.0 - theta * theta) * rest / settings.dt;
  gain_a_ = rest * rest * rest / (settings.dt * settings.dt);
  accelerations_.fill(q_);
  torques_.fill(q_);
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
    return;
  }
  for (int i = 0; i < steps; ++i) advance();
  const JointVector e = q_read - q_;
  q_ += gain_q_ * e;
  v_ += gain_v_ * e;
  a_ += gain_a_ * e;
  forecast();
}

void JointStateEstimator::coast(int steps) noexcept {
  if (!started_) return;
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
                                    const JointVector& tau) noexcept {
  constexpr int kSize = kMaxDelaySteps + 1;
  if (step_ == 0) torques_.fill(tau);
  torques_[step_ % kSize] = tau;
  const JointVector& acting = torques_[(step_ + kSize - torque_steps_) % kSize];
  const JointVector excess = acting + arm.J.transpose().lazyProduct(F_ext) - arm.Cv - arm.g;
  const JointVector modelled = solve(arm.M, excess);
  if (modelled.allFinite()) modelled_ = modelled;
}

}  // namespace impedraw
