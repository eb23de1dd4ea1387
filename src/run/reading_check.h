// Whether what a driver reads can be true: its clock, its stamps, and the motion (motion_check.h).
// The loop asks after every read(), whatever the arm.
//
//   clock   does not go back, and does not stand still for kMostStill readings
//   stamps  of state and wrench: at most 20 ms, and the wrench's known delay, ahead of the clock;
//           not older than start() by more than 1 s
//
// Age within these bounds, and what is not finite, the control law's status tells.
#pragma once

#include <string>

#include "impedraw/run/driver.h"
#include "impedraw/run/motion_check.h"

namespace impedraw {

class ReadingCheck {
 public:
  static constexpr int kMostStill = 20;

  // Rated, of each joint: speed [rad/s], torque [Nm]. wrench_delay [s].
  ReadingCheck(const DriverInfo& driver, const JointVector& speed_limit,
               const JointVector& torque_limit, double wrench_delay);

  // The next reading. torque, external: as MotionCheck has them [Nm]. True in the cycle in which
  // the first contradiction is found. Allocates for its text alone.
  bool update(const ArmState& state, const JointVector& torque,
              const JointVector& external) noexcept;

  // What contradicts what; empty: nothing.
  const std::string& cause() const noexcept { return cause_; }
  // The measured speed as far as positions confirm it; zero where speeds are not measured [rad/s].
  JointVector confirmed(const ArmState& state) const noexcept;

 private:
  std::string contradiction(const ArmState& state);

  bool velocity_, wrench_;  // are measured
  double wrench_delay_;     // [s]
  MotionCheck motion_;
  double time_ = 0.0, state_time_ = 0.0;  // of the last reading; of the last that moved [s]
  int still_ = 0;
  std::string cause_;
};

}  // namespace impedraw
