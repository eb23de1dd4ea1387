// A check that an arm's positions, speeds, clock and torques can be true together.
//
// Limits for two readings Δt apart, with q [rad], v [rad/s] and the joints' rated speeds v_max:
//
//   jump      |Δq| ≤ 3 v_max Δt + 10 mrad. The loop damps an arm at 2.5 v_max.
//   apart     x ← (x + Δq − ½ (v + v₋) Δt) e^(−Δt/1 s), |x| ≤ 8 mrad + v̂ (30 ms + late), with
//             v̂ ← max(|v|, v̂ e^(−Δt/1 s)) up to v_max. A velocity that is filtered over 30 ms is
//             late by as much; late = max(0, Δt − 5 ms) is the error of ½ (v + v₋) over lost
//             readings. A drift with v = 0 is found if its rate is above 8 mrad/s.
//             While v_j stays the same, bit by bit, for 8 ms and 3 readings, no filter explains
//             what positions do beside it: y ← (y + Δq − v Δt) e^(−Δt/50 ms), |y| ≤ 1 mrad.
//   speed     no |v| above 3 v_max of which positions, of the last reading and of 4 ms, have less
//             than a third
//   unmoved   u ← max(0, u + (s − 0.1) Δt) ≤ 150 ms while no joint leaves its place by 0.1 mrad,
//             s the largest share that |τ| − |τ_ext| has of a joint's torque limit. A pen that
//             presses with 10 N asks for less than a tenth. 20 ms of a joint alone that has moved,
//             while its position stays the same, bit by bit.
//   frozen    not: q_j and v_j stay the same, bit by bit, for 8 ms and 3 readings, and |v_j| times
//             that time is above 0.1 mrad
//   stopped   not: q_j stays the same, bit by bit, for 8 ms and 3 readings after a motion that
//             nothing can have ended within one reading: of the joints that stop, v̄ is the least
//             speed of the last 5 readings and of what their last change leads to, all in one
//             direction, less twice the least change of q_j that was ever read, and for one joint k
//             |M v̄|_k/Δt > |Δτ_k| + |Δτ_ext,k| + max(1.5 Nm, 0.02 τ_max,k), also less the change
//             of the other joints' speeds, or three joints stop within the same reading of which
//             one did not creep, below 1 mrad/s. The last torque is what dry friction gains as a
//             joint comes to rest; it does not stop three slow ones at once. A joint that really
//             stops takes the others along.
//
// Values that are not finite are not judged here: whoever reads it says so.
#pragma once

#include <array>
#include <string>

#include "impedraw/control/arm_terms.h"

namespace impedraw {

// The rules of MotionCheck (motion_check.h), which gives their laws. Each takes every reading and
// returns what it contradicts; empty: nothing.

// Rated, of each joint: speed [rad/s], torque [Nm].
struct MotionLimits {
  JointVector speed, torque;
};

// Two readings, dt apart [s].
struct MotionReading {
  const JointVector& q;
  JointVector moved;                     // Δq [rad]
  const JointVector *v, *v_before;       // null: speeds are not measured [rad/s]
  const JointVector &torque, &external;  // [Nm]
  const JointMatrix* M;                  // null: not known [kg m²]
  double dt;
};

// `apart`
class SpeedsBesidePositions {
 public:
  explicit SpeedsBesidePositions(int joints)
      : apart_(JointVector::Zero(joints)), fastest_(apart_) {}
  std::string update(const MotionReading& now, const MotionLimits& limits);

 private:
  JointVector apart_, fastest_;  // x [rad], v̂ [rad/s]
};

// `frozen`, `stopped`, and a steady speed beside which positions move
class ReadingsThatStand {
 public:
  explicit ReadingsThatStand(int joints);
  std::string update(const MotionReading& now, const MotionLimits& limits);

 private:
  // The time for which a value has not changed by a bit.
  struct Same {
    JointVector time, readings;  // [s]
    void update(Eigen::Index j, bool same, double dt) noexcept;
    JointVector lasts() const;  // 1 or 0
  };
  void update_stops(const MotionReading& now, const MotionLimits& limits);

  Same still_, steady_;                // q_j, v_j
  JointVector beside_;                 // y [rad]
  JointVector grain_;                  // least change of q_j that was read: it may be rounded [rad]
  JointVector stopped_;                // v̄_j of a stop that nothing explains; 0: none [rad/s]
  std::array<JointVector, 5> speeds_;  // by positions, of the last readings, in a ring [rad/s]
  std::size_t oldest_ = 0;
  JointVector torque_, external_;  // of the last reading [Nm]
};

// `unmoved`
class TorquesThatMoveNothing {
 public:
  explicit TorquesThatMoveNothing(int joints)
      : held_(JointVector::Constant(joints, -1.0)), place_(JointVector::Zero(joints)) {}
  std::string update(const MotionReading& now, const MotionLimits& limits);

 private:
  JointVector held_;      // u of each joint; below 0: it has not moved yet [s]
  JointVector place_;     // that no joint has left [rad]
  double unmoved_ = 0.0;  // u [s]
};

class MotionCheck {
 public:
  // Rated, of each joint: speed [rad/s], torque [Nm].
  MotionCheck(const JointVector& speed_limit, const JointVector& torque_limit);

  // The next reading, dt > 0 after the last [s]; v null: speeds are not measured. torque: beyond
  // gravity, as it acted until now, and external: as far as it is known [Nm]. M: the arm's inertia
  // thereabouts [kg m²]; null: `stopped` is not judged. Does not throw, and allocates for the text
  // alone. True in the cycle in which the first contradiction is found.
  bool update(const JointVector& q, const JointVector* v, const JointVector& torque,
              const JointVector& external, double dt, const JointMatrix* M = nullptr) noexcept;

  // The contradiction, with the joint and the numbers; empty: nothing.
  const std::string& cause() const noexcept { return cause_; }

  // The measured speed as far as the positions of the last 4 ms confirm it: to damp with [rad/s].
  JointVector confirmed(const JointVector& v) const noexcept;

 private:
  MotionLimits limits_;
  JointVector q_, v_;         // of the last reading
  JointVector by_positions_;  // speed [rad/s]
  SpeedsBesidePositions speeds_;
  ReadingsThatStand stand_;
  TorquesThatMoveNothing torques_;
  bool begun_ = false;
  std::string cause_;
};

// The torque that damps an arm to its end [Nm]: −M v/T. M: inertia at the posture [kg m²]; v
// [rad/s]. Every motion decays at the rate 1/T, also one of joints that turn together, whose
// inertia is many times what each has alone. M is positive definite: its errors add no energy.
inline constexpr double kDampRate = 20.0;  // 1/T [1/s]
inline JointVector damping_torque(const JointMatrix& M, const JointVector& v) noexcept {
  return -kDampRate * M.lazyProduct(v);
}

// It is damped for so long at most [s], or until every joint is slower than this [rad/s].
inline constexpr double kDampTime = 0.3, kDampedSpeed = 0.02;

}  // namespace impedraw
