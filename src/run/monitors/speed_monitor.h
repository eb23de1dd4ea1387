// Notices a motion that the control law no longer controls:
//   a joint well above its speed limit, where the plan and its clock (plan_clock.h) never bring it
//   a joint above it at all, while torques are at their limits, so that the law cannot hold it, or
//   for long
//   a joint above it in both directions in turns: a swing that only the limits keep from growing
//   torques that stay at their limits while the arm moves fast: a limited rate lags behind a swing,
//   and feeds it
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "impedraw/control/joint_speed_shares.h"
#include "impedraw/run/cycle.h"
#include "impedraw/run/monitors/verdict.h"

namespace impedraw {

class SpeedMonitor {
 public:
  // limit: speed of each joint [rad/s]; names: of the joints, for messages.
  explicit SpeedMonitor(const Eigen::VectorXd& limit, std::vector<std::string> names = {})
      : limit_(limit),
        names_(std::move(names)),
        side_(JointVector::Zero(limit.size())),
        since_(side_),
        turns_(side_) {}

  // After each cycle in which the motion is not damped: the measured velocity, and whether a limit
  // on torque or torque rate was active. True in the cycle in which the law has lost control.
  bool update(const JointVector& v, bool torque_limited, double dt) noexcept {
    using Shares = JointSpeedShares;
    int joint = 0;
    const double share = (v.cwiseAbs().array() / limit_.array()).maxCoeff(&joint);
    above_ =
        share > (torque_limited ? Shares::kBrakedLimited : Shares::kBraked) ? above_ + dt : 0.0;
    long_ = share > Shares::kBrakedLimited ? long_ + dt : 0.0;
    limited_ = std::max(0.0, limited_ + (torque_limited ? dt : -dt));
    if (limited_ == 0.0) fastest_ = 0.0;
    if (share > fastest_) {
      fastest_ = share;
      joint_ = joint;
    }
    swings_ = limited_ > kSwing && fastest_ > Shares::kSwing;
    const int to_and_fro = swinging_joint(v, dt);
    if (above_ >= kConfirm || long_ > kLong)
      joint_ = joint;
    else if (to_and_fro >= 0)
      joint_ = to_and_fro;
    else if (!swings_)
      return false;
    above_ = long_ = limited_ = 0.0;
    turns_.setZero();
    return true;
  }

  // The same, after a cycle. The drawing may go on once the motion has been damped.
  Verdict judge(const Cycle& cycle) {
    const bool limited = cycle.out.status.torque_limited;
    if (!update(cycle.arm.v, limited, cycle.dt)) return {};
    const std::string& name = names_[static_cast<std::size_t>(joint_)];
    Verdict verdict;
    verdict.severity = Severity::brake;
    verdict.end = RunEnd::finished;
    verdict.calm = JointSpeedShares::kCalm;
    verdict.cause =
        swings_ ? fmt::format("{} swung at t = {:.3f} s, with torques at their limits", name,
                              cycle.run_time)
                : fmt::format("{} was above its speed limit of {:.2f} rad/s at t = {:.3f} s{}",
                              name, limit_[joint_], cycle.run_time,
                              limited ? ", with torques at their limits" : "");
    return verdict;
  }

  int joint() const { return joint_; }  // that was too fast
  // Torques stayed at their limits; no joint was above its speed limit.
  bool swings() const { return swings_; }

 private:
  // Returns a joint that was above its limit in kTurns + 1 alternating directions, else −1.
  int swinging_joint(const JointVector& v, double dt) noexcept {
    for (int j = 0; j < limit_.size(); ++j) {
      since_[j] += dt;
      if (since_[j] > kPeriod) turns_[j] = 0.0;
      if (std::abs(v[j]) <= limit_[j]) continue;
      const double side = std::copysign(1.0, v[j]);
      if (side != side_[j] && since_[j] < kPeriod) ++turns_[j];
      side_[j] = side;
      since_[j] = 0.0;
      if (turns_[j] >= kTurns) return j;
    }
    return -1;
  }

  static constexpr double kLong = 0.25;     // above kBrakedLimited [s]
  static constexpr double kConfirm = 3e-3;  // longer than an outlier of a noisy velocity [s]
  // Time at the torques' limits, less the time off them [s]. A drawing at 200 mm/s with 900 Nm/s is
  // there for 1 ms.
  static constexpr double kSwing = 0.15;
  static constexpr double kPeriod = 0.5, kTurns = 4;  // [s]

  JointVector limit_;
  std::vector<std::string> names_;
  // For each joint: the side on which it was above its limit, the time since then, and its turns.
  JointVector side_, since_, turns_;
  bool swings_ = false;
  double above_ = 0.0, long_ = 0.0, limited_ = 0.0;  // [s]
  double fastest_ = 0.0;                             // share, in the time limited_
  int joint_ = 0;
};

}  // namespace impedraw
