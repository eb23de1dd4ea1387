// Holds an arm on a wall clock while the loop that drives it is busy: such an arm must be answered
// in every cycle, and does not wait until a controller is made or a file is written.
//
// Law   τ = g + M ( α²/4 (q_0 − q) − α v ), α of damping_torque(): critically damped about the
//       posture q_0 in which it began, each |q_0 − q| at most kMostSpring. An arm without measured
//       velocities gets g alone.
#pragma once

#include <atomic>
#include <thread>

#include "impedraw/arm/arm_model.h"
#include "impedraw/run/driver.h"

namespace impedraw {

class HeldArm {
 public:
  static constexpr double kMostSpring = 0.1;  // [rad]

  // Reads the arm where `state`, which was not answered yet, is null. From now on nobody else may
  // call the driver until release().
  HeldArm(Driver& driver, const ArmModel& arm, const ArmState* state = nullptr);
  ~HeldArm() { release(); }

  const JointVector& posture() const noexcept { return q_0_; }
  // The driver has reported a fault, and is called no more.
  bool failed() const noexcept { return failed_; }
  // Ends it. The last state, which was not answered yet.
  const ArmState* release();

 private:
  void answer() noexcept;

  Driver& driver_;
  ArmModel arm_;
  ArmTerms terms_;
  const ArmState* state_;
  JointVector q_0_;
  std::atomic<bool> ends_ = false, failed_ = false;
  std::thread thread_;
};

}  // namespace impedraw
