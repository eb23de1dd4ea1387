// Test fixture: the iiwa in seeded random states.
#pragma once

#include <random>

#include "impedraw/arm/arm_model.h"
#include "impedraw/arm/inverse_kinematics.h"
#include "impedraw/control/impedance.h"

namespace impedraw::testing_arm {

inline constexpr const char* kArm = "models/iiwa14_pen.urdf";

inline JointVector working_posture() {
  JointVector q(7);
  q << 0.1, 0.6, -0.1, -1.4, 0.2, 1.1, 0.3;
  return q;
}

inline ArmTerms random_terms(ArmModel& arm, std::mt19937& rng) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  JointVector q = working_posture(), v(7);
  for (int i = 0; i < 7; ++i) {
    q[i] += 0.5 * unit(rng);
    v[i] = unit(rng);
  }
  ArmTerms terms(7);
  arm.compute(q, v, &terms);
  return terms;
}

inline ImpedanceSettings shaped_settings(const ArmModel& arm) {
  ImpedanceSettings s;
  s.null_space.q_0 = working_posture();
  s.limits.torque = arm.limits().torque;
  return s;
}

inline ImpedanceSettings natural_settings(const ArmModel& arm) {
  ImpedanceSettings s = shaped_settings(arm);
  s.inertia = InertiaShaping::natural;
  s.wrench = WrenchFeedback::none;
  return s;
}

}  // namespace impedraw::testing_arm
