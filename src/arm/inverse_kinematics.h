// Inverse kinematics for a pen with given tip position and axis, and maybe heading: five degrees of
// freedom, or six.
#pragma once

#include "impedraw/arm/arm_model.h"

namespace impedraw {

struct PenPlacement {
  Eigen::Vector3d p_WE;  // desired tip [m]
  Eigen::Vector3d z_WE;  // desired pen axis, unit, out of the tip
  // Desired heading: x_E, unit, across z; zero: the rotation about the pen is free.
  Eigen::Vector3d x_WE = Eigen::Vector3d::Zero();

  bool led() const { return x_WE.squaredNorm() > 0.5; }
};

struct IkSettings {
  double position_tolerance = 1e-7;  // [m]
  double axis_tolerance = 1e-7;      // [rad]
  int max_steps = 200;
  double posture_gain = 0.2;  // pull of the redundant joints towards the seed, per step
  // Rotation about the pen: free, or none on the way from the seed, as the controller damps it.
  bool free_spin = true;
};

struct IkResult {
  JointVector q;  // best posture, within the joint limits
  bool reached = false;
  double position_error = 0.0;  // [m]
  double axis_error = 0.0;      // of the heading, too, where that is led [rad]
};

// Damped least squares from `seed`, clamped to the joint limits at each step. The redundant joints
// stay near the seed.
IkResult find_posture(ArmModel& arm, const PenPlacement& desired, const JointVector& seed,
                      const IkSettings& settings = {});

}  // namespace impedraw
