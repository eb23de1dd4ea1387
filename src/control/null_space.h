// Torque that moves the arm within itself, and does not move the tip: towards a rest posture and
// away from the ends of the joints' ranges.
//
// Law      τ = (I − Jᵀ J̄ᵀ) τ_null                                                 (17)
//          τ_null = s K_q (q_0 − q) − d D_q v + τ_limit,  D_q = 2 ζ √(K_q diag(M))  (14)–(15)
//          τ_limit: joint_range.torque · depth², away from an end of a joint's range
// Fading   s: from a speed of the fastest joint of kSelfMotionSpeed on the pull fades where it
//          speeds the arm up, to 0 at twice that. Past a singular posture, which has held it, the
//          arm would swing back to q_0 at several times its joints' speed limits.
// Calming  d: from kCalmSpeed on the damping rises, to 1 + kMoreDamping times at twice that, as far
//          as it is well within what the sampled loop bears (bearable_rate of damping.h).
// Light    Where little inertia moves with the self-motion, as in a light arm or at a stretched
//          elbow, the loop bears less. The pull leads to z = M⁻¹ (I − Jᵀ J̄ᵀ) K_q (q_0 − q), and its
//          damping has the rate r = zᵀ D_q z / zᵀ M z. d r is at most r_b = 1/(Δt + delay), as a
//          damping that late swings from π/2 times that on. s is such that z / r_b, the speed in
//          which pull and damping would end, is within the joints' limits.
// Requires `space` updated for `arm`; settings completed for its joints
#pragma once

#include "impedraw/control/joint_range.h"

namespace impedraw {

class NullSpace {
 public:
  static constexpr double kSelfMotionSpeed = 1.0;  // [rad/s]
  // Cosine between pull and motion from which on the pull fades wholly. Less than that, by degrees:
  // the pull would come and go where it begins to slow the arm down.
  static constexpr double kAlong = 0.3;
  static constexpr double kCalmSpeed = 0.7;  // [rad/s]
  static constexpr double kMoreDamping = 12.0;

  explicit NullSpace(const ImpedanceSettings& settings);

  // (I − Jᵀ J̄ᵀ) τ_null [Nm]
  JointVector torque(const ArmTerms& arm, const OperationalSpace& space,
                     const JointRange& range) noexcept;
  // τ_null [Nm]
  JointVector unprojected(const ArmTerms& arm, const OperationalSpace& space,
                          const JointRange& range) noexcept;
  // A joint is in the margin of an end of its range.
  bool near_range_end() const noexcept { return near_range_end_; }

 private:
  JointVector range_torque(const JointVector& q, const JointRange& range) noexcept;

  JointVector stiffness_, q_0_;  // K_q [Nm/rad], [rad]
  double damping_ratio_;         // ζ
  double range_torque_;          // at the end of a range [Nm]
  JointVector joint_speed_;      // limits [rad/s]; empty: none
  double damping_delay_;         // [s]
  bool near_range_end_ = false;
};

}  // namespace impedraw
