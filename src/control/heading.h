// Turning the pen about its own axis, which the task leaves free, away from the ends of the joints'
// ranges.
//
// Law      ω = 2 rad/s · clamp(Σ_j s_j J̄_j / max_j |J̄_j|, ±1),  s_j = depth_lower² − depth_upper²
//          J̄_j: speed of joint j for 1 rad/s about the pen's axis z_E
// Without it, on closed lines about a hill, the pen's heading and the last joint with it turn on
// and on. Torque in the null space cannot turn them back: the turn moves the tip frame.
// Requires `space` updated for `arm`
#pragma once

#include <algorithm>

#include "impedraw/control/joint_range.h"

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

}  // namespace impedraw
