// Differences between the simulated arm and the URDF that the controller uses. All are off by
// default. Dry friction is in WorldSettings.
//
// Plant, true        M' v̇ + C' v + g' = τ_a − b v + …
//                    M', C', g' with mass_scale and centre_shift; M' with the true rotor_inertia
//                    on the diagonal
// Torque that acts   τ_a = round(τ(t − loop_delay) / quantum) quantum + A sin(30 q_j + φ_j)
//                    φ_j = 2π · 0.381966 j: a different phase for each joint
#pragma once

#include <vector>

#include "impedraw/common/range.h"

namespace impedraw {

struct ModelErrors {
  static constexpr double kRipplePeriods = 30.0;  // per turn of the joint
  static constexpr int kMostDelaySteps = 16;

  double mass_scale = 1.0;  // of mass and inertia of every link, including the pen; > 0
  // shift of the c.o.m. along (1,1,1)/√3 of the link's axes, for every link with its own joint;
  // excludes the pen [m]
  double centre_shift = 0.0;
  double viscous_friction = 0.0;  // b, every joint, ≥ 0 [Nm s/rad]
  // True, about every joint's axis or about each, ≥ 0; empty: what the URDF says (arm_notes.h),
  // else zero [kg m²]
  std::vector<double> rotor_inertia;
  // Dry friction's course (gear_friction.h)
  double stiction = 1.0;         // at rest, a multiple of that in motion
  double stribeck_speed = 0.02;  // to which that reaches [rad/s]
  double load_friction = 0.0;    // more of it for each Nm that the gear carries
  double friction_ripple = 0.0;  // a share of it
  double torque_ripple = 0.0;    // A, every joint [Nm]
  double torque_quantum = 0.0;   // torque resolution, ≥ 0; 0: continuous [Nm]
  // rounded to steps, at most kMostDelaySteps; the first torque acts without delay [s]
  double loop_delay = 0.0;
  // offset of the true tip E along its z from its place in the URDF [m]
  double pen_longer = 0.0;

  struct Limits {
    static constexpr Limit mass_scale = {"mass_scale", "", {0.1, 10.0}};
    static constexpr Limit centre_shift = {"centre_shift", "m", {-0.2, 0.2}};
    static constexpr Limit viscous_friction = {"viscous_friction", "Nm s/rad", {0.0, 100.0}};
    static constexpr Limit rotor_inertia = {"rotor_inertia", "kg m²", {0.0, 10.0}};
    static constexpr Limit stiction = {"stiction", "", {1.0, 10.0}};
    static constexpr Limit stribeck_speed = {"stribeck_speed", "rad/s", {1e-4, 10.0}};
    static constexpr Limit load_friction = {"load_friction", "", {0.0, 1.0}};
    static constexpr Limit friction_ripple = {"friction_ripple", "", {0.0, 1.0}};
    static constexpr Limit torque_ripple = {"torque_ripple", "Nm", {0.0, 20.0}};
    static constexpr Limit torque_quantum = {"torque_quantum", "Nm", {0.0, 10.0}};
    static constexpr Limit loop_delay = {"loop_delay", "s", {0.0, 0.015}};
    static constexpr Limit pen_longer = {"pen_longer", "m", {-0.02, 0.02}};
  };
};

}  // namespace impedraw
