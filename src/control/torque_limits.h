// Limits on torque and torque rate. They apply to the sum of projected torques and preserve the
// task as far as possible.
//
// Desired     τ = τ_hold + τ_task + τ_null
// Limits      |τ_j| ≤ limit_j
// In order    1. A null-space torque (I − Jᵀ J̄ᵀ) e_j α is added, for the joint j furthest outside
//                the box, with the least |α| that brings all joints inside. It has no effect at
//                the tip. For an arm of seven joints this is the whole null space; an arm of six
//                has none.
//             2. τ_task is scaled by the largest s in [0, 1] for which step 1 succeeds. The wrench
//                at the tip keeps its direction.
//             3. If no s succeeds, each joint is clipped.
// Rate        |τ_j − τ_j,last| ≤ rate_j Δt, last: nearest(). To keep the direction of the task's
//             change would slow every joint, the quick wrist too, to the slowest one's rate: a lag
//             in the loop (docs/decisions/0013).
// First       The metric of nearest() is of M − ρ g gᵀ/(gᵀ M⁻¹ g), g = Jᵀ n: a lack of the tip's
//             acceleration along n counts 1/(1 − ρ) times, ρ in [0, 1). A canvas that comes
//             unforeseen presses with what the arm's rates leave of its inertia.
// Requires    limit > 0, rate > 0, n entries each, as ImpedanceSettings::validate() checks; `space`
//             updated for `arm`; torques of n entries.
// Result      always within limits and rates. Neither throws nor allocates.
// Clipping each joint at its limit, as is common, changes the direction of the wrench at the tip
// for as long as the limit is met.
// Clipping τ_null after its projection disturbs that wrench.
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
  // limit [Nm], rate [Nm/s]: ±, one entry per joint. An empty rate means no rate limit.
  TorqueLimits(const Eigen::VectorXd& limit, const Eigen::VectorXd& rate, double dt);

  LimitedTorque apply(const JointVector& hold, const JointVector& task, const JointVector& null,
                      const ArmTerms& arm, const OperationalSpace& space,
                      const Eigen::Vector3d& n = Eigen::Vector3d::UnitZ(),
                      double rho = 0.0) noexcept;
  // The torque within limits and rates whose acceleration is nearest to that of `tau`: least
  // (τ − tau)ᵀ M⁻¹ (τ − tau). While one joint's torque is still on its way, the others keep it from
  // throwing them about. M: the joints' inertia, n×n, positive definite; exact to 1e-9 Nm.
  LimitedTorque nearest(const JointVector& tau, const JointMatrix& M) noexcept;
  // Clips each joint. For a torque without a task, such as the one commanded after bad input.
  LimitedTorque clip(const JointVector& tau) noexcept;

  void reset() noexcept { started_ = false; }  // the next torque has no rate limit

 private:
  bool inside(const JointVector& tau) const noexcept;
  void clip_rate(LimitedTorque* out) noexcept;

  JointVector limit_, step_;  // step: rate Δt [Nm]; empty: none
  JointVector last_;
  bool started_ = false;
};

}  // namespace impedraw
