// Notices a motion that the control law no longer controls, and has the loop damp it until it has
// calmed down:
//   a joint well above its speed limit, where the plan and its clock (plan_clock.h) never bring it
//   a joint above it at all, while torques are at their limits, so that the law cannot hold it, or
//   for long
//   a joint above it in both directions in turns: a swing that only the limits keep from growing
//   torques that stay at their limits while the arm moves fast: a limited rate lags behind a swing,
//   and feeds it
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "impedraw/control/arm_terms.h"

namespace impedraw {

class SpeedGuard {
 public:
  // `limit`: of each joint [rad/s].
  explicit SpeedGuard(const Eigen::VectorXd& limit)
      : limit_(limit), side_(JointVector::Zero(limit.size())), since_(side_), turns_(side_) {}

  // Called once per cycle, with the measured velocity, and whether a limit on torque or torque rate
  // was active. True in the cycle in which the guard trips.
  bool update(const JointVector& v, bool torque_limited, double dt) noexcept {
    calmed_ = false;
    int joint = 0;
    const double share = (v.cwiseAbs().array() / limit_.array()).maxCoeff(&joint);
    if (!braking_) {
      above_ = share > (torque_limited ? kTripLimited : kTrip) ? above_ + dt : 0.0;
      long_ = share > kTripLimited ? long_ + dt : 0.0;
      limited_ = std::max(0.0, limited_ + (torque_limited ? dt : -dt));
      if (limited_ == 0.0) fastest_ = 0.0;
      if (share > fastest_) {
        fastest_ = share;
        joint_ = joint;
      }
      swings_ = limited_ > kSwing && fastest_ > kSwingShare;
      const int to_and_fro = swinging_joint(v, dt);
      if (above_ >= kConfirm || long_ > kLong)
        joint_ = joint;
      else if (to_and_fro >= 0)
        joint_ = to_and_fro;
      else if (!swings_)
        return false;
      braking_ = true;
      braked_ = above_ = long_ = limited_ = 0.0;
      turns_.setZero();
      return true;
    }
    braked_ += dt;
    if (share < calm_ || braked_ > kLongest) {
      braking_ = false;
      calmed_ = true;
    }
    return false;
  }

  // Brakes as if it had tripped, and until the arm stands.
  void brake() noexcept {
    calm_ = kStill;
    if (braking_) return;
    braking_ = true;
    braked_ = above_ = 0.0;
  }

  bool braking() const { return braking_; }
  bool calmed() const { return calmed_; }  // true in the cycle in which braking ended
  int joint() const { return joint_; }     // that tripped the guard
  // It tripped since torques stayed at their limits, not by a joint's speed.
  bool swings() const { return swings_; }

 private:
  // That was above its limit in kTurns + 1 directions, alternating; or −1.
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

  static constexpr double kTrip = 2.5;         // share of the limits; a stop of a joint gives 1.9
  static constexpr double kTripLimited = 1.2;  // the clock stops the plan at 1.15
  static constexpr double kLong = 0.25;        // above 1.2 [s]
  static constexpr double kConfirm = 3e-3;     // longer than an outlier of a noisy velocity [s]
  // Time at the torques' limits, less the time off them [s], and the fastest joint in that time. A
  // drawing at 200 mm/s with 900 Nm/s is there for 1 ms.
  static constexpr double kSwing = 0.15, kSwingShare = 0.5;
  static constexpr double kPeriod = 0.5, kTurns = 4;  // [s]
  static constexpr double kCalm = 0.05;               // share of the limits
  static constexpr double kStill = 0.002;             // share of the limits
  static constexpr double kLongest = 0.5;             // [s]

  JointVector limit_;
  // Of each joint: the side on which it was above its limit, the time since then, and its turns.
  JointVector side_, since_, turns_;
  double calm_ = kCalm;  // share at which braking ends
  bool braking_ = false, calmed_ = false, swings_ = false;
  double above_ = 0.0, long_ = 0.0, braked_ = 0.0, limited_ = 0.0;  // [s]
  double fastest_ = 0.0;
  int joint_ = 0;
};

}  // namespace impedraw
