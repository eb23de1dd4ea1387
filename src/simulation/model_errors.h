// What the true arm does that its URDF, and with it the controller, knows nothing of. All off by
// default. Dry friction: WorldSettings.
//
// Plant, true        M' v̇ + C' v + g' = τ_a − b v + …
//                    M', C', g' with mass_scale and centre_shift; M' with rotor_inertia added on
//                    the diagonal
// Torque that acts   τ_a = round(τ(t − loop_delay) / quantum) quantum + A sin(30 q_j + φ_j)
//                    φ_j = 2π · 0.381966 j, so that all differ
#pragma once

namespace impedraw {

struct ModelErrors {
  static constexpr double kRipplePeriods = 30.0;  // per turn of the joint
  static constexpr int kMostDelaySteps = 16;

  double mass_scale = 1.0;  // of mass and inertia of every link, the pen too; above 0
  // c.o.m. of every link with a joint of its own, along (1,1,1)/√3 of its axes: not the pen's [m]
  double centre_shift = 0.0;
  double viscous_friction = 0.0;  // b, every joint, ≥ 0 [Nm s/rad]
  double rotor_inertia = 0.0;     // on every joint's own axis, ≥ 0 [kg m²]
  double torque_ripple = 0.0;     // A, every joint [Nm]
  double torque_quantum = 0.0;    // torque acts in multiples of it, ≥ 0; 0: none [Nm]
  // in steps, rounded, at most kMostDelaySteps; until the first torque arrives it acts already [s]
  double loop_delay = 0.0;
  // the true tip E lies so much further along its z than the URDF says [m]
  double pen_longer = 0.0;
};

}  // namespace impedraw
