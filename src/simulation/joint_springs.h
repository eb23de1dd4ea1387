// Joints with springs: spring and damper between each rotor and its link, as gear and torque sensor
// are, and the arm's own torque loop. θ: the rotor's position over the gear's ratio.
//
//   link    M v̇ + C v + g = τ_J + Jᵀ F
//   spring  τ_J = K (θ − q) + D (θ̇ − v)
//   rotor   B θ̈ = τ_m − τ_J − b θ̇ − τ_f          b, τ_f: the gear's friction (gear_friction.h)
//   sensor  s = τ_J + ε,  ε = ripple sin(30 θ + φ_j) ± offset
//   loop    τ_m = s + (B/B_θ) (u − s − (2ζ/ω) ṡ),  B_θ = K/ω² ≤ B,  u: the commanded torque
//
// With the link held and D = 0, the loop is τ_J/u = ω²/(s² + 2ζω s + ω²). What it leaves of the
// rotor is the inertia B_θ, and of the gear's friction the share B_θ/B: Ott, Albu-Schäffer, Kugi
// and Hirzinger, On the Passivity-Based Impedance Control of Flexible Joint Robots, IEEE T-RO 24
// (2008).
// A loop that is slower than √(K/B) leaves B as it is.
//
// One step of h
//   τ_J = K (δ + h/4 (δ̇⁺ − δ̇)) + D (δ̇⁺ + δ̇)/2,  δ = θ − q
// With q⁺ = q + h v⁺ that is the trapezoidal rule for δ − h δ̇/2: stable at any step, and
// ½ K (δ − h δ̇/2)² with the kinetic energies changes by D's loss alone. The loop acts on the torque
// at the end of the step, since an arm's own loop runs faster than h. On the link this is a torque
// τ_0 − c v⁺: see viscous friction in compiled_arm.h. Dry friction takes v for v⁺, which h² K ≪ B
// allows.
#pragma once

#include "impedraw/control/arm_terms.h"
#include "impedraw/simulation/gear_friction.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

// Values of each joint; published ones stand in for those that are not given.
struct JointSpringValues {
  Eigen::VectorXd stiffness, damping, rotor_inertia;  // K, D, B
  double loop_bandwidth = 0.0;                        // ω
  bool motor_side = false;                            // what the sensors read

  Eigen::VectorXd apparent_inertia() const;  // B_θ [kg m²]
  Eigen::VectorXd loop_lag() const;          // 2ζ/ω where the loop acts, else 0 [s]
};

// Throws InputError for values out of range, too few or too many, or a rotor without inertia.
JointSpringValues joint_spring_values(const JointSpringSettings& settings, int joints);

class JointSprings {
 public:
  static constexpr double kLoopDamping = 0.7;  // ζ

  // b: viscous friction of each joint [Nm s/rad]; h: of an integration step [s].
  JointSprings(const JointSpringSettings& settings, const JointVector& b,
               const GearFriction& friction, double h);

  // At rest relative to the links, with the springs carrying τ_J. Allocates nothing from here on.
  void reset(const JointVector& q, const JointVector& v, const JointVector& tau_J) noexcept;

  // c, of τ_0 − c v⁺ [Nm s/rad].
  const JointVector& link_damping() const { return link_damping_; }
  // τ_0 of the step that begins at (q, v) under the commanded torque u.
  const JointVector& begin(const JointVector& u, const JointVector& q,
                           const JointVector& v) noexcept;
  // The links' velocity at its end.
  void finish(const JointVector& v) noexcept;

  const JointVector& theta() const { return theta_; }  // [rad]
  const JointVector& theta_rate() const { return rate_; }
  const JointVector& torque() const { return torque_; }  // τ_J over the last step [Nm]
  bool motor_side() const { return values_.motor_side; }

 private:
  JointSpringValues values_;
  GearFriction friction_;
  double ripple_, offset_, h_;
  JointVector share_, lag_, inertia_;    // B_θ/B, 2ζ/ω, B_θ
  JointVector stiff_, coupling_, mass_;  // K h/4 + D/2; h (1 + lag/h) of it; of θ̇⁺
  JointVector b_, link_damping_;
  JointVector theta_, rate_, torque_, sensed_;      // state
  JointVector known_, base_, error_, link_torque_;  // of the step that goes on
};

}  // namespace impedraw
