// Operational-space impedance with inertia shaping, a constant push along the surface normal, and a
// consistent null space.
//
// Law         a     = V̇_d + M_d⁻¹ ( B (V_d − V) + K e + F_push + F_compliant )
//             F_act = Λ ( a − J̇v + J M⁻¹ C v ) − F_ext
//             (10)–(11)
//             τ     = Jᵀ F_act + (I − Jᵀ J̄ᵀ) τ_null + g − r,   τ_null = K_q (q_0 − q) − D_q v +
//                   τ_limit  (12), (14)–(17)
// Closed loop M_d (V̇ − V̇_d) = B (V_d − V) + K e + F_push + F_compliant
// (1)
// F_compliant is F_ext less what friction at the tip explains, so that the pen gives way to a hand
// but not to its own friction. Without a measured wrench M_d must be Λ; then F_act needs no F_ext
// and the plant's own F_ext stands in (1).
//
// r is what a momentum observer finds the model to miss. τ_limit pushes a joint back from its
// limit, never less the nearer it is: τ_limit = limit_torque ((margin − d)/margin)² for d < margin,
// d the distance to the limit.
//
// In contact  e is the error seen along the drawing axis z, taken for the ink rather than the tip:
//             (13), ErrorProjection;
//             K has no normal part; F_push = −F_n n; z_E goes to −n, the turn about it is only
//             damped.
// At a switch of mode the desired force stays continuous: the difference is carried over and fades
// with `switch_time`. The speed on which spring and damper would settle, V_d + B⁻¹ K e, is held
// within tip_speed_limit (Khatib's velocity saturation). Torque and its rate are limited last, with
// the task kept as far as it can be (torque_limits.h).
//
// Needs       M symmetric positive definite; all vectors in the number of joints given at set-up;
//             n_WD and n_W unit vectors; a call every dt;
//             J of full row rank: near a singularity the lost direction is released and
//             `status.near_singular` says so.
// Source      Khatib, "A unified approach for motion and force control of robot manipulators: the
//             operational space formulation", IEEE
//             J. Robotics and Automation 3(1), 1987; equation numbers: "Drawing With Operation
//             Space Impedance Control", see README.
// step() allocates nothing and throws nothing. With a state that is not finite, or stale, it goes
// to the last gravity torque, as fast as the rate limit lets; with a wrench that is stale the pen
// retreats from the surface. `status` says so.
#pragma once

#include "impedraw/control/contact_mode.h"
#include "impedraw/control/damping.h"
#include "impedraw/control/impedance_settings.h"
#include "impedraw/control/momentum_observer.h"
#include "impedraw/control/normal_tracker.h"
#include "impedraw/control/surface_estimate.h"
#include "impedraw/control/tip_reference.h"
#include "impedraw/control/torque_limits.h"

namespace impedraw {

using Wrench = Vector6;  // [force; torque] at the origin of E, in W [N, Nm]

enum TorqueTerm {
  kFeedforward,
  kImpedance,
  kPush,
  kWrench,
  kVelocityProduct,
  kNullSpace,
  kGravity,
  kDisturbance,
  kTorqueTerms
};
inline constexpr std::string_view kTorqueTermNames[] = {
    "feedforward",      "impedance",  "push",    "wrench",
    "velocity_product", "null_space", "gravity", "disturbance"};

// How old the inputs of a step are, beyond what the set-up was told [s].
struct InputAges {
  double state = 0.0, wrench = 0.0;
};

struct ControlStatus {
  // not finite, of another size, M not positive definite, a normal not unit: the last gravity
  // torque
  bool bad_input = false;
  bool near_singular = false;  // a direction of the tip was released
  bool stale_state = false;    // too old: as for bad input
  bool stale_wrench = false;   // too old: no contact without it
  // a limit on torque or its rate was met; the task is kept as far as it can be
  bool torque_limited = false;
  bool speed_limited = false;  // the law asked for more speed than it may
  bool joint_limit = false;    // a joint is within the margin of its limit
  bool surface_lost = false;   // contact is desired and perception has no surface here
  bool damping_limit = false;  // M_d = Λ: max eig(M_d⁻¹B)(Δt + delay) ≥ 0.5 in this posture
  bool ok() const {
    return !(bad_input || near_singular || stale_state || stale_wrench || torque_limited ||
             speed_limited || joint_limit || surface_lost || damping_limit);
  }
};

struct ImpedanceTorque {
  JointVector tau;  // after limits [Nm]
  Eigen::Matrix<double, Eigen::Dynamic, kTorqueTerms, Eigen::ColMajor, kMaxJoints, kTorqueTerms>
      terms;  // a column each, sum before limits
  ContactMode mode = ContactMode::free;
  ControlStatus status;
  double push = 0.0;                                // normal force asked for [N]
  double task_share = 1.0;                          // what the torque limits left of the task
  Eigen::Vector3d p_WD = Eigen::Vector3d::Zero();   // desired tip, compensation included [m]
  Eigen::Vector3d n_WD = Eigen::Vector3d::UnitZ();  // desired normal: z_D = −n_WD
};

class ImpedanceController {
 public:
  // Throws InputError naming the setting, its value and what would be valid: an inertia that cannot
  // be had or would not be stable, sizes that differ, a shaped inertia without a wrench.
  ImpedanceController(const ImpedanceSettings& settings, int joints);

  // One step. The answer is this object's own, overwritten by the next step. `reference`: the plan
  // at this instant. `surface`: perception at the tip, status `none` to be blind. `F_ext` needs
  // feedback to count.
  const ImpedanceTorque& step(const ArmTerms& arm, const TipReference& reference,
                              const SurfaceEstimate& surface, const Wrench& F_ext,
                              const InputAges& ages = {}) noexcept;

  void reset() noexcept;  // as new: mode free, nothing carried over

 private:
  // The desired motion, and the force that acts on M_d, B and K, of one step.
  struct ReferenceMotion {
    Vector6 V_d, Vdot_d;
    Vector6 force;  // B (V_d − V) + K e
    Vector6 push;   // F_push
  };

  bool valid(const ArmTerms& arm, const TipReference& reference, const SurfaceEstimate& surface,
             const Wrench& F_ext) const noexcept;
  const ImpedanceTorque& safe_torque() noexcept;
  void forget() noexcept;
  void update_mode(const TipReference& reference, const SurfaceEstimate& surface,
                   const Wrench& F_ext) noexcept;
  ReferenceMotion reference_on_plan(const ArmTerms& arm, const TipReference& reference) noexcept;
  ReferenceMotion reference_on_surface(const ArmTerms& arm, const TipReference& reference,
                                       const SurfaceEstimate& surface) noexcept;
  Vector6 damp(const Vector6& V) const noexcept;  // B V
  void pull(
      const Vector6& V, const Vector6& Ke,
      ReferenceMotion* desired) noexcept;  // its force: B (V_d − V) + K e, within the speed limit
  Vector6 tip_friction(const ArmTerms& arm, const Wrench& F_ext) const noexcept;
  void update_force_integral(const Wrench& F_ext) noexcept;
  JointVector limit_repulsion(const JointVector& q) noexcept;

  ImpedanceSettings settings_;
  bool shaped_, measured_;
  double scale_;  // c of M_d = c Λ
  JointVector q_0_, null_stiffness_, lower_, upper_;
  OperationalSpace space_;
  ModalDamping modal_damping_;
  TipGain shaped_damping_;
  MomentumObserver observer_;
  TorqueLimits limits_;
  NormalTracker tracker_;
  ContactStates contact_;
  bool hand_over_ = false;   // the desired force is to start from zero
  bool on_surface_ = false;  // the last step's law was the one for approach and contact
  ContactMode last_mode_ = ContactMode::free;
  double force_integral_ = 0.0;     // [N]
  double approach_distance_ = 0.0;  // desired distance to the surface during the approach [m]
  Vector6 carried_force_ = Vector6::Zero();  // handed over at the last switch, fading
  Vector6 last_force_ = Vector6::Zero();     // force + push of the last step
  ImpedanceTorque out_;
};

}  // namespace impedraw
