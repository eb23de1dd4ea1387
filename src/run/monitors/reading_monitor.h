// Notices that a driver's readings cannot be true: its clock, its stamps, and, unless its session
// looks at that, the motion (motion_check.h). The loop asks after every read(), whatever the arm. A
// contradiction ends the run.
//
//   clock   does not go back, and does not stand still for 20 readings; in lock-step it does not go
//           on by more than 20 periods at once
//   stamps  of state and wrench: at most 20 ms, and the wrench's known delay, ahead of the clock;
//           not older than start() by more than 1 s
//
//   wrench  that says 1 N and more act on the tip: not the same, bit by bit, while the tip moves by
//           5 mm along the normal
//
// Ages within these bounds and numbers that are not finite are left to the control law's status.
#pragma once

#include <cmath>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "impedraw/run/cycle.h"
#include "impedraw/run/monitors/verdict.h"
#include "impedraw/run/motion_check.h"

namespace impedraw {

class ReadingMonitor {
 public:
  // Rated, of each joint: speed [rad/s], torque [Nm]. wrench_delay [s]. felt: the wrench on the tip
  // is measured.
  ReadingMonitor(const DriverInfo& driver, const JointVector& speed_limit,
                 const JointVector& torque_limit, double wrench_delay, bool felt = false)
      : driver_(driver), torque_limit_(torque_limit), wrench_delay_(wrench_delay), felt_(felt) {
    if (!driver.checks_motion) motion_.emplace(speed_limit, torque_limit);
  }

  // The next reading. torque, external, M: as MotionCheck has them [Nm], [kg m²]. True in the
  // cycle in which the first contradiction is found. Allocates for its text alone.
  bool update(const ArmState& state, const JointVector& torque, const JointVector& external,
              const JointMatrix* M = nullptr) noexcept {
    const std::string found = contradiction(state);
    time_ = state.time;
    const bool speeds = driver_.velocity;
    if (motion_ && !state.stalled && state.q.allFinite() && (!speeds || state.v.allFinite())) {
      motion_->update(state.q, speeds ? &state.v : nullptr, torque, external,
                      state.state_time - state_time_, M);
      state_time_ = state.state_time;
    }
    if (!cause_.empty()) return false;
    cause_ = found.empty() && motion_ ? motion_->cause() : found;
    return !cause_.empty();
  }

  // The same, after a cycle. is_damped: the motion is, which takes no wrench; a hand that pushes
  // evenly looks like one that stands still.
  Verdict judge(const Cycle& cycle, bool is_damped = false) {
    const JointVector torque = cycle.out.tau - cycle.out.terms.col(kGravity);
    if (felt_ && stands_still(cycle, is_damped) && cause_.empty()) {
      cause_ = fmt::format(
          "the wrench stands still: the force on the tip is still {:.1f} N, 5 mm along the normal",
          cycle.F_ext.head<3>().norm());
    } else if (!update(*cycle.state, torque, external(cycle), &cycle.arm.M)) {
      return {};
    }
    return {Severity::damp, fmt::format("{} at t = {} s", cause(), told(cycle.next_run_time()))};
  }

  // The contradiction that was found; empty: none.
  const std::string& cause() const noexcept { return cause_; }
  // The measured speed as far as positions confirm it; zero where speeds are not measured, or the
  // driver checks them [rad/s].
  JointVector confirmed(const ArmState& state) const noexcept {
    return motion_ && driver_.velocity ? motion_->confirmed(state.v)
                                       : JointVector::Zero(state.v.size());
  }

 private:
  // Joint torques that are known to hold or turn the arm beside the law's motion: of what acts on
  // the tip, and of what the observer makes of the model's errors, up to a share of the limits.
  JointVector external(const Cycle& cycle) const noexcept {
    constexpr double kErrors = 0.2;
    Wrench F = cycle.F_ext;
    if (!felt_) F << cycle.out.push * cycle.out.n_WD, Eigen::Vector3d::Zero();
    const JointVector tau = cycle.arm.J.transpose().lazyProduct(F);
    return tau.cwiseAbs() +
           cycle.out.terms.col(kDisturbance).cwiseAbs().cwiseMin(kErrors * torque_limit_);
  }

  bool stands_still(const Cycle& cycle, bool is_damped) noexcept {
    constexpr double kPushes = 1.0, kMoved = 5e-3;  // [N], [m]
    const Eigen::Vector3d& p_WE = cycle.arm.X_WE.p;
    // A wrench whose stamp is old is the law's concern.
    const bool old = cycle.state->time - cycle.state->wrench_time > kAhead + wrench_delay_;
    if (is_damped || old || cycle.state->wrench != wrench_ ||
        !(cycle.F_ext.head<3>().norm() > kPushes)) {
      wrench_ = cycle.state->wrench;
      p_WE_ = p_WE;
    }
    return std::abs((p_WE - p_WE_).dot(cycle.out.n_WD)) > kMoved;
  }

  static std::string told(double t) {  // in a few digits, whatever a clock says
    return std::abs(t) < 1e7 ? fmt::format("{:.3f}", t) : fmt::format("{:.3g}", t);
  }

  std::string contradiction(const ArmState& state) {
    constexpr int kMostStill = 20;   // readings, periods
    constexpr double kOldest = 1.0;  // [s]
    still_ = state.time == time_ ? still_ + 1 : 0;
    if (still_ > kMostStill) return "the arm's clock stands still";
    if (!(state.time >= time_))
      return fmt::format("the arm's clock went back from {:.3f} s to {} s", time_,
                         told(state.time));
    if (driver_.waits && time_ > 0.0 && state.time > time_ + kMostStill * driver_.period)
      return fmt::format("the arm's clock jumped ahead from {:.3f} s to {} s", time_,
                         told(state.time));
    const auto outside = [&](const char* what, double stamp, double delay) -> std::string {
      const double ahead = stamp - state.time;
      if (ahead <= kAhead + delay && stamp >= -kOldest) return {};
      return fmt::format("the {} is stamped {} s {} the arm's clock", what, told(std::abs(ahead)),
                         ahead < 0.0 ? "behind" : "ahead of");
    };
    const std::string cause = outside("joint state", state.state_time, 0.0);
    if (!cause.empty() || driver_.wrench == WrenchReading::none) return cause;
    return outside("wrench", state.wrench_time, wrench_delay_);
  }

  static constexpr double kAhead = 0.02;  // [s]

  DriverInfo driver_;
  JointVector torque_limit_;
  double wrench_delay_;  // [s]
  bool felt_;
  std::optional<MotionCheck> motion_;
  double time_ = 0.0, state_time_ = 0.0;            // the last reading; the last that moved [s]
  Vector6 wrench_ = Vector6::Zero();                // the last that was another
  Eigen::Vector3d p_WE_ = Eigen::Vector3d::Zero();  // where it was measured [m]
  int still_ = 0;
  std::string cause_;
};

}  // namespace impedraw
