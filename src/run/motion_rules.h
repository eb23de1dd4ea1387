// The rules of MotionCheck (motion_check.h), which gives their laws. Each takes every reading and
// returns what it contradicts; empty: nothing.
#pragma once

#include <array>
#include <string>

#include "impedraw/control/arm_terms.h"

namespace impedraw {

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
  // How long a value has not changed by a bit.
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

}  // namespace impedraw
