#include "impedraw/sensing/wrench_estimator.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

void require(bool valid, const char* name, double value, const char* unit, const char* desired) {
  if (valid) return;
  char message[256];
  std::snprintf(message, sizeof message, "wrench sensor: %s = %g %s, must be %s", name, value, unit,
                desired);
  throw InputError(message);
}

void check(const WrenchEstimatorSettings& s) {
  require(s.dt > 0.0 && std::isfinite(s.dt), "dt", s.dt, "s", "finite and above 0");
  check_tool(s.tool);
  if (!s.X_ES.p.allFinite() || !s.X_ES.R.isUnitary(1e-6) || !(s.X_ES.R.determinant() > 0.0)) {
    throw InputError("wrench sensor: X_ES must be a finite position and a rotation");
  }
  if (!s.gravity_W.allFinite()) throw InputError("wrench sensor: gravity_W must be finite");
  char longest[64];
  std::snprintf(longest, sizeof longest, "in 0 … %g s (%d steps)",
                WrenchEstimator::kMaxDelaySteps * s.dt, WrenchEstimator::kMaxDelaySteps);
  require(s.sensor_delay >= 0.0 && s.sensor_delay / s.dt < WrenchEstimator::kMaxDelaySteps + 0.5,
          "sensor_delay", s.sensor_delay, "s", longest);
  char widest[64];
  std::snprintf(widest, sizeof widest, "at least 0 and below 2/dt = %g rad/s", 2.0 / s.dt);
  require(s.filter_bandwidth >= 0.0 && s.filter_bandwidth * s.dt < 2.0, "filter_bandwidth",
          s.filter_bandwidth, "rad/s", widest);
  require(s.tare_time >= s.dt && s.tare_time / s.dt < 1e9, "tare_time", s.tare_time, "s",
          "finite and at least a step");
  require(s.tare_speed > 0.0, "tare_speed", s.tare_speed, "m/s", "above 0");
  require(s.tare_turn_rate > 0.0, "tare_turn_rate", s.tare_turn_rate, "rad/s", "above 0");
  require(s.range_force > 0.0, "range_force", s.range_force, "N", "above 0");
  require(s.range_torque > 0.0, "range_torque", s.range_torque, "Nm", "above 0");
}

}  // namespace

WrenchEstimator::WrenchEstimator(const WrenchEstimatorSettings& settings) : settings_(settings) {
  check(settings);
  p_SE_ = settings.X_ES.inverse().p;
  const double w_dt = settings.filter_bandwidth * settings.dt;
  filter_gain_ = w_dt / (2.0 + w_dt);
  tare_length_ = static_cast<int>(std::lround(settings.tare_time / settings.dt));
  rest_gain_ = settings.dt / (settings.dt + 0.5 * settings.tare_time);
  motions_kept_ = static_cast<int>(std::lround(settings.sensor_delay / settings.dt)) + 2;
}

const Vector6& WrenchEstimator::update(const Vector6& reading_S, const Pose& X_WE,
                                       const Vector6& V_WE) noexcept {
  const bool motion_valid = X_WE.p.allFinite() && X_WE.R.allFinite() && V_WE.allFinite();
  if (motion_valid) {
    remember(X_WE, V_WE);
  } else {
    known_ = 0;
  }
  const bool motion_known = known_ == motions_kept_;
  fault_ = !motion_valid || !reading_valid(reading_S) || (tared_ && !motion_known);
  if (fault_ && taring_) start_tare();
  if (fault_ || !motion_known) return F_ext_;

  const ToolMotion motion = motion_of_reading();
  const Vector6 residue_S = reading_S - tool_wrench(settings_.tool, motion, settings_.gravity_W);
  if (taring_) tare(residue_S, motion);
  if (!tared_) return F_ext_;

  const Vector6& u_S = filter(residue_S - bias_S_);
  const Eigen::Vector3d f = u_S.head<3>(), m = u_S.tail<3>();
  F_ext_ << motion.X_WS.R * f, motion.X_WS.R * (m - p_SE_.cross(f));
  return F_ext_;
}

void WrenchEstimator::start_tare() noexcept {
  taring_ = true;
  tare_steps_ = 0;
  tare_sum_.setZero();
}

void WrenchEstimator::lengthen_pen(double by) noexcept {
  settings_.X_ES.p.z() -= by;
  p_SE_ = settings_.X_ES.inverse().p;
  known_ = 0;
}

double WrenchEstimator::group_delay() const {
  return settings_.sensor_delay +
         (settings_.filter_bandwidth > 0.0 ? 2.0 / settings_.filter_bandwidth : 0.0);
}

void WrenchEstimator::remember(const Pose& X_WE, const Vector6& V_WE) noexcept {
  newest_ = (newest_ + 1) % motions_kept_;
  known_ = std::min(known_ + 1, motions_kept_);
  Motion& motion = motions_[newest_];
  motion.X_WS = X_WE * settings_.X_ES;
  const Eigen::Vector3d v = V_WE.head<3>(), w = V_WE.tail<3>();
  motion.V_WS << v + w.cross(X_WE.R * settings_.X_ES.p), w;
}

ToolMotion WrenchEstimator::motion_of_reading() const noexcept {
  const Motion& start = motions_[(newest_ + 1) % motions_kept_];
  const Motion& end = motions_[(newest_ + 2) % motions_kept_];
  ToolMotion motion;
  motion.X_WS.p = 0.5 * (start.X_WS.p + end.X_WS.p);
  // deviates from a rotation by (ωΔt)²/8: 1e-5 at 10 rad/s
  motion.X_WS.R = 0.5 * (start.X_WS.R + end.X_WS.R);
  motion.V_WS = 0.5 * (start.V_WS + end.V_WS);
  motion.A_WS = (end.V_WS - start.V_WS) / settings_.dt;
  return motion;
}

bool WrenchEstimator::reading_valid(const Vector6& reading_S) const noexcept {
  return reading_S.allFinite() &&
         reading_S.head<3>().cwiseAbs().maxCoeff() < settings_.range_force &&
         reading_S.tail<3>().cwiseAbs().maxCoeff() < settings_.range_torque;
}

void WrenchEstimator::tare(const Vector6& residue_S, const ToolMotion& motion) noexcept {
  const Eigen::Vector3d v_WS = motion.V_WS.head<3>(), w_WS = motion.V_WS.tail<3>();
  const Eigen::Vector3d v_WE = v_WS + w_WS.cross(motion.X_WS.R * p_SE_);
  Vector6 V;
  V << v_WE, w_WS;
  mean_motion_ += rest_gain_ * (V - mean_motion_);
  if (!(mean_motion_.head<3>().norm() < settings_.tare_speed &&
        mean_motion_.tail<3>().norm() < settings_.tare_turn_rate)) {
    start_tare();
    return;
  }
  tare_sum_ += residue_S;
  if (++tare_steps_ < tare_length_) return;
  bias_S_ = tare_sum_ / tare_steps_;
  tared_ = true;
  taring_ = false;
}

const Vector6& WrenchEstimator::filter(const Vector6& u_S) noexcept {
  if (settings_.filter_bandwidth == 0.0) {
    filter_out_ = u_S;
    return filter_out_;
  }
  const Vector6 middle = filter_middle_ + filter_gain_ * (u_S + filter_in_ - 2.0 * filter_middle_);
  filter_out_ += filter_gain_ * (middle + filter_middle_ - 2.0 * filter_out_);
  filter_in_ = u_S;
  filter_middle_ = middle;
  return filter_out_;
}

}  // namespace impedraw
