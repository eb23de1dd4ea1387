// Notices a motion that the control law no longer controls: a joint well above its speed limit,
// where the plan and its clock (plan_clock.h) never bring it; or above it at all, while torques are
// at their limits, so that the law cannot hold it. The loop then damps the motion until it has
// calmed down.
#pragma once

#include <Eigen/Core>

#include "impedraw/control/arm_terms.h"

namespace impedraw {

class SpeedGuard {
 public:
  // `limit`: of each joint [rad/s].
  explicit SpeedGuard(const Eigen::VectorXd& limit) : limit_(limit) {}

  // Called once per cycle, with the measured velocity, and whether a limit on torque or torque rate
  // was active. True in the cycle in which the guard trips.
  bool update(const JointVector& v, bool torque_limited, double dt) noexcept {
    calmed_ = false;
    int joint = 0;
    const double share = (v.cwiseAbs().array() / limit_.array()).maxCoeff(&joint);
    if (!braking_) {
      above_ = share > (torque_limited ? kTripLimited : kTrip) ? above_ + dt : 0.0;
      if (above_ < kConfirm) return false;
      braking_ = true;
      braked_ = above_ = 0.0;
      joint_ = joint;
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

 private:
  static constexpr double kTrip = 2.5;         // share of the limits; a stop of a joint gives 1.9
  static constexpr double kTripLimited = 1.2;  // the clock stops the plan at 1.15
  static constexpr double kConfirm = 3e-3;     // longer than an outlier of a noisy velocity [s]
  static constexpr double kCalm = 0.05;        // share of the limits
  static constexpr double kStill = 0.002;      // share of the limits
  static constexpr double kLongest = 0.5;      // [s]

  JointVector limit_;
  double calm_ = kCalm;  // share at which braking ends
  bool braking_ = false, calmed_ = false;
  double above_ = 0.0, braked_ = 0.0;  // [s]
  int joint_ = 0;
};

}  // namespace impedraw
