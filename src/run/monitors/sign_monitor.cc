#include "impedraw/run/monitors/sign_monitor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace impedraw {
namespace {

constexpr double kQuick = 200.0, kMean = 50.0;            // [rad/s]
constexpr double kSlowTorque = 80.0, kSlowWrench = 12.0;  // [rad/s]
constexpr double kOpposed = 1.5, kMost = 2.5, kMadeUp = 0.8, kAlike = 0.94;
constexpr double kLeastForce = 0.8, kLeastPush = 5.0;  // of the push, that counts from there [N]
constexpr double kMadeUpForce = 9.0, kPull = 2.5;      // [N]
constexpr double kMasses = 0.1;                        // of the tip's acceleration
constexpr double kHabit = 0.1, kAboveHabit = 9.0;      // [rad/s]; of squares
constexpr double kLeastTorque = 2.0, kShare = 0.01;    // [Nm], of the limit
constexpr int kLasts = 4;                              // cycles: longer than an outlier

// The share of a step that a low-pass of that bandwidth follows.
double followed(double bandwidth, double dt) { return 1.0 - std::exp(-bandwidth * dt); }

double wrench_age(const TimingSettings& t) {
  return std::max(0.0, t.wrench_delay - t.dt - t.velocity_age);
}

}  // namespace

SignMonitor::SignMonitor(const ImpedanceSettings& s, const JointVector& torque_limit)
    : felt_(s.wrench == WrenchFeedback::measured),
      dt_(s.timing.dt),
      quick_share_(followed(kQuick, dt_)),
      mean_share_(followed(kMean, dt_)),
      habit_share_(followed(kHabit, dt_)),
      late_(static_cast<std::size_t>(std::lround(
          (wrench_age(s.timing) + s.timing.torque_delay() + s.timing.velocity_age) / dt_))),
      observer_({true, kQuick, 1000.0, {}}, static_cast<int>(torque_limit.size()), dt_,
                wrench_age(s.timing), s.timing.torque_delay() + s.timing.velocity_age),
      v_(JointVector::Zero(torque_limit.size())),
      least_(Channels::Constant(torque_limit.size() + 3,
                                kLeastForce * std::max(kLeastPush, s.normal_force))),
      slow_(Channels::Constant(torque_limit.size() + 3, followed(kSlowWrench, dt_))) {
  least_.head(torque_limit.size()) = (kShare * torque_limit.array()).max(kLeastTorque);
  const double across =
      s.friction.coefficient + std::tan(s.friction.normal_error_deg * std::numbers::pi / 180.0);
  least_.segment<2>(torque_limit.size()) =
      least_.segment<2>(torque_limit.size()).max(across * std::max(kLeastPush, s.normal_force));
  slow_.head(torque_limit.size()).setConstant(followed(kSlowTorque, dt_));
  weightless_.fill(v_);
  quick_ = x_slow_ = y_slow_ = size_quick_ = size_slow_ = xx_ = xy_ = yy_ = sizes_ = habit_ =
      Channels::Zero(least_.size());
  all_quick_ = all_slow_ = alls_ = Eigen::Array3d::Zero();
}

Verdict SignMonitor::update(const ArmTerms& arm, const OperationalSpace* space,
                            const Vector6& F_ext, const JointVector& tau) noexcept {
  // A state that was read before teaches nothing, and neither does rest.
  if (!space || arm.v == v_ || !arm.v.allFinite() || !F_ext.allFinite() || !tau.allFinite()) {
    observer_.pause();
    return {};
  }
  v_ = arm.v;
  const Eigen::Index n = tau.size();
  const Vector6 F = felt_ ? F_ext : Vector6::Zero();
  const JointVector r = observer_.update(arm, F);
  observer_.commanded(tau);
  weightless_[step_ % kHistory] = tau - arm.g;
  const JointVector& weightless = weightless_[(step_ + kHistory - 1 - late_) % kHistory];
  ++step_;
  Channels x = Channels::Zero(n + 3), y = x, size = x;
  Eigen::Array3d all = Eigen::Array3d::Zero();
  x.head(n) = size.head(n) = weightless;
  y.head(n) = r;
  if (felt_) {
    const Eigen::Matrix3d to_pen = arm.X_WE.R.transpose();
    x.tail<3>() = to_pen * space->tip_acceleration_by(F).head<3>();
    y.tail<3>() = to_pen * space->tip_acceleration(r).head<3>();
    size.tail<3>() = to_pen * F.head<3>();
    all = x.tail<3>() + (to_pen * space->tip_acceleration(weightless).head<3>()).array();
    Vector6 along = Vector6::Zero();
    along.head<3>() = to_pen.row(2).transpose();
    held_ = -y[n + 2] / along.dot(space->tip_acceleration_by(along));
  }
  quick_ += quick_share_ * (x - quick_);
  size_quick_ += quick_share_ * (size - size_quick_);
  all_quick_ += quick_share_ * (all - all_quick_);
  x_slow_ += slow_ * (quick_ - x_slow_);
  y_slow_ += slow_ * (y - y_slow_);
  size_slow_ += slow_ * (size_quick_ - size_slow_);
  all_slow_ += slow_.tail<3>() * (all_quick_ - all_slow_);
  x = quick_ - x_slow_;
  y -= y_slow_;
  xx_ += mean_share_ * (x * x - xx_);
  xy_ += mean_share_ * (x * y - xy_);
  yy_ += mean_share_ * (y * y - yy_);
  sizes_ += mean_share_ * ((size_quick_ - size_slow_).square() - sizes_);
  alls_ += mean_share_ * ((all_quick_ - all_slow_).square() - alls_);
  habit_ += habit_share_ * (yy_ - habit_);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    // A fading product is the end of a push, and of the friction beside it.
    if (x[i] * x[i] < xx_[i] || xy_[i] * xy_[i] < kAlike * xx_[i] * yy_[i]) continue;
    if (yy_[i] < kAboveHabit * habit_[i]) continue;
    const double rms = std::sqrt(sizes_[i]), slope = xy_[i] / xx_[i];
    const bool joint = i < n, pulls = i == n + 2 && size_quick_[i] > kPull;
    const bool within = slope > -kMost;
    const bool opposed = within && slope < -kOpposed && (rms > least_[i] || pulls);
    const bool made_up = within && !joint && slope < -kMadeUp &&
                         rms * (1.0 - kMasses * std::sqrt(alls_[i - n] / xx_[i])) > kMadeUpForce;
    if (!opposed && !made_up) continue;
    if (++lasts_ < kLasts) return {};
    if (joint)
      return {Severity::lose,
              fmt::format("joint {} turns against its torque of {:.1f} Nm: a sign is wrong", i + 1,
                          weightless[i])};
    return {Severity::damp,
            fmt::format("the arm moves {} along the tip's {}",
                        opposed ? "against the measured wrench, whose sign is wrong,"
                                : "as if the measured wrench did not act",
                        "xyz"[i - n])};
  }
  lasts_ = 0;
  return {};
}

}  // namespace impedraw
