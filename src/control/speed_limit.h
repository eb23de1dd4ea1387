// Limits the speed at which the springs and the plan take the tip (Khatib's velocity saturation).
//
// Law      V_end = V_d + B⁻¹ K e, the steady-state speed of spring and damper, is scaled to limits.
//          tip_speed and turn_speed; then its turn, and if that is not enough all of it, until no
//          joint exceeds its speed limit, nor the one before the end of its range (joint_range.h).
//          V_end then takes the place of V_d, and 0 that of K e: B (V_d − V) + K e = B (V_end − V).
// Joints   The arm keeps the motion that does not move the tip: near a singularity that motion
//          moves the wrist faster than the tip's does.
// Feed-    The part of V̇_d that accelerates the tip along V_end is removed by degrees, in full from
// forward  1/kHoldBack of the speed on: torque would step at a limit that comes and goes.
// Requires `space` and `impedance` updated for `arm`
// Source   Khatib 1987 (impedance.h)
#pragma once

#include "impedraw/control/joint_range.h"
#include "impedraw/control/tip_impedance.h"
#include "impedraw/control/tip_target.h"

namespace impedraw {

class SpeedLimit {
 public:
  static constexpr double kHoldBack = 20.0;
  // Below all of these the tip stays far below any limit, and the solves are skipped.
  static constexpr double kSlow = 0.15;        // speed [m/s] and turn [rad/s] that no joint minds
  static constexpr double kSlowShare = 0.8;    // share of the limits on speed and turn
  static constexpr double kNearEnd = 0.06;     // distance to an end of a joint's range [rad]
  static constexpr double kSmallError = 2e-3;  // [m]
  static constexpr double kSmallAngle = 2e-2;  // [rad]
  static constexpr double kSmallAngleOfJoints = 5e-3;  // [rad], where joints have a speed limit

  explicit SpeedLimit(const ImpedanceSettings& settings) : limits_(settings.limits) {}

  // Returns true if it has changed *target: V, V̇ and K e.
  bool apply(const ArmTerms& arm, const OperationalSpace& space, const TipImpedance& impedance,
             const JointRange& range, TipTarget* target) const noexcept;

 private:
  bool is_slow(const ArmTerms& arm, const TipImpedance& impedance, const JointRange& range,
               const TipTarget& target) const noexcept;

  LimitSettings limits_;
};

// Scales the turn of V, then all of it, until no joint exceeds its speed limit.
void keep_joint_speeds(const ArmTerms& arm, const OperationalSpace& space, const JointRange& range,
                       Vector6* V) noexcept;

}  // namespace impedraw
