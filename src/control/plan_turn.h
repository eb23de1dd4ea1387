// The plan's angular acceleration, as far as the rates of the torques follow it. At an edge of 20°
// it comes and goes within a hundredth of a second: torques on their way to it turn the pen on when
// it is long over, joints near their speed limits, and the tip leaves the surface.
//
// Law       α ← α min(1, kTurnTime rate_j / |Jᵀ Λ (0, α)|_j)
// Requires  `space` updated for `arm`; rate: the limits' torque_rate, one entry per joint, or none
#pragma once

#include <algorithm>

#include "impedraw/control/impedance_settings.h"
#include "impedraw/control/operational_space.h"
#include "impedraw/control/tip_reference.h"

namespace impedraw {

inline constexpr double kTurnTime = 0.01;  // in which torques may grow to the feedforward [s]

// The reference with α as it is followed.
inline TipReference with_followed_turn(const ArmTerms& arm, const OperationalSpace& space,
                                       const LimitSettings& limits,
                                       const TipReference& reference) noexcept {
  TipReference followed = reference;
  Eigen::Vector3d& alpha = followed.alpha_WD;
  if (limits.torque_rate.size() == 0 || alpha.isZero(0.0)) return followed;
  const Vector6 F = space.inertia().rightCols<3>() * alpha;
  const JointVector tau = arm.J.transpose().lazyProduct(F);
  const double time = tau.cwiseAbs().cwiseQuotient(limits.torque_rate).maxCoeff();
  alpha /= std::max(1.0, time / kTurnTime);
  return followed;
}

}  // namespace impedraw
