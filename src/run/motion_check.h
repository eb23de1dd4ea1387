// A check that an arm's positions, speeds, clock and torques can be true together.
//
// Limits for two readings Δt apart, with q [rad], v [rad/s] and the joints' rated speeds v_max:
//
//   jump      |Δq| ≤ 3 v_max Δt + 10 mrad. The loop damps an arm at 2.5 v_max.
//   apart     x ← (x + Δq − ½ (v + v₋) Δt) e^(−Δt/1 s), |x| ≤ 20 mrad + v_max (30 ms + late).
//             A velocity that is filtered over 30 ms and then goes from 0 to v_max is late by as
//             much; late = max(0, Δt − 5 ms) is the error of ½ (v + v₋) over lost readings. A
//             drift with v = 0 is found if its rate [rad/s] is above that bound [rad]: 0.09 on an
//             iiwa's, 0.18 on an FR3's fastest joint. A slower one is not noticed here.
//   speed     no |v| above 3 v_max of which positions, of the last reading and of 4 ms, have less
//             than a third
//   unmoved   u ← max(0, u + (s − 0.1) Δt) ≤ 150 ms while no joint leaves its place by 0.1 mrad,
//             s the largest share that |τ| − |τ_ext| has of a joint's torque limit. A pen that
//             presses with 10 N asks for less than a tenth.
//
// Values that are not finite are not judged here: whoever reads it says so.
#pragma once

#include <string>

#include "impedraw/control/arm_terms.h"

namespace impedraw {

class MotionCheck {
 public:
  // Rated, of each joint: speed [rad/s], torque [Nm].
  MotionCheck(const JointVector& speed_limit, const JointVector& torque_limit);

  // The next reading, dt > 0 after the last [s]; v null: speeds are not measured. torque: beyond
  // gravity, as it acted until now, and external: as far as it is known [Nm]. Does not throw, and
  // allocates for the text alone. True in the cycle in which the first contradiction is found.
  bool update(const JointVector& q, const JointVector* v, const JointVector& torque,
              const JointVector& external, double dt) noexcept;

  // The contradiction, with the joint and the numbers; empty: nothing.
  const std::string& cause() const noexcept { return cause_; }

  // The measured speed as far as the positions of the last 4 ms confirm it: to damp with [rad/s].
  JointVector confirmed(const JointVector& v) const noexcept;

 private:
  std::string contradiction(double dt) const;

  JointVector speed_limit_, torque_limit_;
  JointVector q_, v_;          // of the last reading
  JointVector moved_, apart_;  // since the one before; x [rad]
  JointVector by_positions_;   // speed [rad/s]
  JointVector place_;          // that no joint has left [rad]
  double unmoved_ = 0.0;       // u [s]
  double share_ = 0.0;         // s
  bool begun_ = false;
  std::string cause_;
};

// D_j = 1/(T (M⁻¹)_jj): with n joints no mode is damped faster than n/T, so that a delay of T/n/2
// and less stays harmless. M: inertia at the posture [kg m²], T [s].
JointVector joint_damping(const JointMatrix& M, double T = 0.1);

// An arm that is damped by D to its end is damped for so long at most [s], or until every joint is
// slower than this [rad/s].
inline constexpr double kDampTime = 0.3, kDampedSpeed = 0.02;

}  // namespace impedraw
