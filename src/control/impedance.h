// Operational-space impedance with inertia shaping, a constant push along the surface normal, and a consistent null space.
//
// Law         a     = V̇_d + M_d⁻¹ ( B (V_d − V) + K e + F_push + F_kept )
//             F_act = Λ ( a − J̇v + J M⁻¹ C v ) − F_ext                                             (10)–(11)
//             τ     = Jᵀ F_act + (I − Jᵀ J̄ᵀ) τ_null + g,   τ_null = K_q (q_0 − q) − D_q v           (12), (14)–(17)
// Closed loop M_d (V̇ − V̇_d) = B (V_d − V) + K e + F_push + F_kept                                   (1)
// F_kept is F_ext less what friction at the tip explains, so that the pen gives way to a hand but not to its own friction. Without a
// measured wrench M_d must be Λ; then F_act needs no F_ext and the plant's own F_ext stands in (1).
//
// In contact  e is the error seen along the drawing axis z, taken for the ink rather than the tip: (13), ErrorProjection;
//             K has no normal part; F_push = −F_n n; z_E goes to −n, the turn about it is only damped.
// At a switch of mode the wanted force stays continuous: the difference is carried over and fades with `switch_time`.
//
// Needs       J of full row rank; near a singularity the lost direction is released and `status.near_singular` says so.
// step() allocates nothing and throws nothing; with bad input it returns a safe torque (the last gravity torque) and `status.bad_input`.
#pragma once

#include "control/contact_mode.h"
#include "control/damping.h"
#include "control/impedance_settings.h"
#include "control/normal_tracker.h"
#include "control/surface_estimate.h"
#include "control/tip_goal.h"

namespace impedraw {

using Wrench = Vector6;  // [force; torque] at the origin of E, in W [N, Nm]

enum TorqueTerm { kFeedforward, kImpedance, kPush, kWrench, kVelocityProduct, kNullSpace, kGravity, kTorqueTerms };
inline constexpr std::string_view kTorqueTermNames[] = {"feedforward",      "impedance",  "push",   "wrench",
                                                        "velocity_product", "null_space", "gravity"};

struct ControlStatus {
  bool bad_input = false;       // something was not finite; the torque is the last gravity torque
  bool near_singular = false;   // a direction of the tip was released
  bool torque_limited = false;  // a joint was clipped
  bool surface_lost = false;    // contact is wanted and perception has no surface here
  bool damping_limit = false;   // M_d = Λ: max eig(M_d⁻¹B)(Δt + delay) ≥ 0.5 in this posture
  bool ok() const { return !(bad_input || near_singular || torque_limited || surface_lost || damping_limit); }
};

struct ImpedanceTorque {
  JointVector tau;                                                                              // after limits [Nm]
  Eigen::Matrix<double, Eigen::Dynamic, kTorqueTerms, Eigen::ColMajor, kMaxJoints, kTorqueTerms> terms;  // a column each, sum before limits
  ContactMode mode = ContactMode::free;
  ControlStatus status;
  double push = 0.0;                                            // normal force asked for [N]
  Eigen::Vector3d p_WD = Eigen::Vector3d::Zero();               // wanted tip, compensation included [m]
  Eigen::Vector3d n_WD = Eigen::Vector3d::UnitZ();              // wanted normal: z_D = −n_WD
};

class ImpedanceController {
 public:
  // Throws InputError naming the setting, its value and what would be valid: an inertia that cannot be had or would not be stable,
  // sizes that differ, a shaped inertia without a wrench.
  ImpedanceController(const ImpedanceSettings& settings, int joints);

  // One step. `goal`: the plan at this instant. `surface`: perception at the tip, status `none` to be blind. `F_ext` needs feedback to count.
  const ImpedanceTorque& step(const ArmTerms& arm, const TipGoal& goal, const SurfaceEstimate& surface, const Wrench& F_ext) noexcept;

  void reset() noexcept;  // as new: mode free, nothing carried over

 private:
  // The wanted motion, and the force that acts on M_d, B and K, of one step.
  struct Wanted {
    Vector6 V_d, Vdot_d;
    Vector6 force;  // B (V_d − V) + K e
    Vector6 push;   // F_push
  };

  bool finite(const ArmTerms& arm, const TipGoal& goal, const SurfaceEstimate& surface, const Wrench& F_ext) const noexcept;
  void update_mode(const TipGoal& goal, const SurfaceEstimate& surface, const Wrench& F_ext) noexcept;
  Wanted want_on_plan(const ArmTerms& arm, const TipGoal& goal) noexcept;
  Wanted want_on_surface(const ArmTerms& arm, const TipGoal& goal, const SurfaceEstimate& surface) noexcept;
  Vector6 damp(const Vector6& V) const noexcept;
  Vector6 tip_friction(const ArmTerms& arm, const Wrench& F_ext) const noexcept;
  void limit_torque() noexcept;

  ImpedanceSettings settings_;
  JointVector q_0_, null_stiffness_, torque_limit_;
  OperationalSpace space_;
  ModalDamping modal_damping_;
  TipGain shaped_damping_;
  NormalTracker tracker_;
  ContactStates contact_;
  bool on_surface_ = false;           // the last step's law was the one for approach and contact
  ContactMode last_mode_ = ContactMode::free;
  double approach_distance_ = 0.0;    // wanted distance to the surface during the approach [m]
  Vector6 carried_force_ = Vector6::Zero();  // handed over at the last switch, fading
  Vector6 last_force_ = Vector6::Zero();     // force + push of the last step
  ImpedanceTorque out_;
};

}  // namespace impedraw
