// Limits on torque and on its rate, applied to the sum after projection, with the task kept as far
// as it can be.
//
// Desired     τ = τ_hold + τ_task + τ_null
// Box         |τ_j| ≤ limit_j,  |τ_j − τ_j,last| ≤ rate_j Δt
// In order    1. A null-space torque is added, (I − Jᵀ J̄ᵀ) e_j α for the joint j that is furthest
//                out, the least |α| that brings all in: the tip feels nothing of it. Of an arm of
//                seven joints that is the whole null space; an arm of six has none.
//             2. τ_task is scaled by the largest s in [0, 1] for which 1. succeeds: the wrench at
//                the tip keeps its direction.
//             3. Where no s does, each joint is clipped.
// Needs       limit > 0, rate > 0, n entries each, as ImpedanceSettings::validate() checks; `space`
//             updated for `arm`; the sum a torque of n numbers.
// Answers     never outside of the box. Neither throws nor allocates.
// Clipping each joint at once, as is common, turns the wrench at the tip, and clipping τ_null after
// its projection leaks into it.
#pragma once

#include "impedraw/control/operational_space.h"

namespace impedraw {

struct LimitedTorque {
  JointVector tau;
  bool limited = false;
  double task_share = 1.0;  // s
};

class TorqueLimits {
 public:
  // limit [Nm], rate [Nm/s]: ±, one entry per joint; an empty rate is none.
  TorqueLimits(const Eigen::VectorXd& limit, const Eigen::VectorXd& rate, double dt);

  LimitedTorque apply(const JointVector& hold, const JointVector& task, const JointVector& null,
                      const ArmTerms& arm, const OperationalSpace& space) noexcept;
  // Joint by joint, for a torque that has no task: what is commanded after bad input.
  LimitedTorque clip(const JointVector& tau) noexcept;

  void reset() noexcept { started_ = false; }  // the next torque has no predecessor

 private:
  void find_box(int n) noexcept;
  bool inside(const JointVector& tau) const noexcept;

  JointVector limit_, step_;   // step: rate Δt [Nm]; empty: none
  JointVector lower_, upper_;  // the box of this step
  JointVector last_;
  bool started_ = false;
};

}  // namespace impedraw
