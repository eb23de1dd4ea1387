// The pen's heading: its turn about its own axis, which the task leaves free, or leads.
//
// Free     ω = 2 rad/s · clamp(Σ_j s_j J̄_j / max_j |J̄_j|, ±1),  s_j = depth_lower² − depth_upper²
//          J̄_j: speed of joint j for 1 rad/s about the pen's axis z_E
//          away from the ends of the joints' ranges. Without it, on closed lines about a hill, the
//          pen's heading and the last joint with it turn on and on. Torque in the null space cannot
//          turn them back: the turn moves the tip frame.
// Led      V_d += ψ̇ n,  V̇_d += ψ̈ n,  K e += k ψ_e n,   ψ_e = ∠(x_E, x_D) about n, within ± π
//          a blade. k: stiffness about the normal. Nothing then keeps joints from the ends of their
//          ranges but the null space; the plan has to (tool_fit.h).
// Requires `space` updated for `arm`
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "impedraw/control/joint_range.h"
#include "impedraw/control/tip_reference.h"
#include "impedraw/control/tip_target.h"

namespace impedraw {

inline constexpr double kHeadingRate = 2.0;  // at the end of a joint's range [rad/s]

// ω about z_E [rad/s]
inline double heading_rate(const ArmTerms& arm, const OperationalSpace& space,
                           const JointRange& range) noexcept {
  JointVector away = JointVector::Zero(arm.q.size());
  for (Eigen::Index j = 0; j < range.ranges(); ++j) {
    const JointRange::Depth depth = range.depth(arm.q, j);
    away[j] = depth.lower * depth.lower - depth.upper * depth.upper;
  }
  if (away.isZero()) return 0.0;
  Vector6 spin = Vector6::Zero();
  spin.tail<3>() = arm.X_WE.R.col(2);
  const JointVector by_spin = space.joint_speed(spin);
  return kHeadingRate * std::clamp(away.dot(by_spin) / by_spin.cwiseAbs().maxCoeff(), -1.0, 1.0);
}

// From a to b about the unit n, of vectors that are not along n [rad], within ± π.
inline double yaw_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                          const Eigen::Vector3d& n) noexcept {
  return std::atan2(n.dot(a.cross(b)), a.dot(b) - n.dot(a) * n.dot(b));
}

// Adds a led heading to the target. stiffness: k [Nm/rad].
inline void lead_heading(const TipReference& plan, const Pose& X_WE, double stiffness,
                         TipTarget* d) noexcept {
  const Eigen::Vector3d& n = d->axis_WD;
  d->V.tail<3>() += plan.yaw_rate * n;
  d->Vdot.tail<3>() += plan.yaw_acceleration * n;
  d->Ke.tail<3>() += stiffness * yaw_between(X_WE.R.col(0), plan.x_WD, n) * n;
}

}  // namespace impedraw
