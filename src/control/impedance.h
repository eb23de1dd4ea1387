// Operational-space impedance control of a pen tip: inertia shaping, a constant push along the
// surface normal, and a consistent null space.
//
// Law
//   a      = V̇_d + M_d⁻¹ ( B (V_d − V) + K e + F_push + F_compliant )          (1)
//   F_act  = Λ ( a − J̇v + J M⁻¹ C v ) − F_ext                                  (10)–(11)
//   τ      = Jᵀ F_act + (I − Jᵀ J̄ᵀ) τ_null + g − r_y                           (12), (16)–(17)
//   τ_null = K_q (q_0 − q) − D_q v + τ_limit                                   (14)–(15)
//
// Closed loop
//   M_d (V̇ − V̇_d) = B (V_d − V) + K e + F_push + F_compliant                   (1)
//
// Symbols, for an arm of n joints (arm_terms.h). Vectors of six have the linear part first, are
// expressed in the world frame W and taken at the origin of the tip frame E.
//   q, v, τ, g      n      joint position, velocity, torque, gravity torque    rad, rad/s, Nm
//   M, C v          n×n, n joint inertia, Coriolis and centrifugal torque      kg m², Nm
//   J, J̇v           6×n, 6 tip Jacobian, drift acceleration                    m, m/s²
//   Λ, J̄            6×6, n×6  (8), (16): operational_space.h                   kg, kg m²
//   V_d, V̇_d, e     6      reference motion and its error: reference_motion.cc m/s, m/s², m, rad
//   M_d, K          6×6    desired inertia and stiffness: impedance_settings.h kg, N/m, Nm/rad
//   B               6×6    damping from M_d and K: damping.h                   N s/m, Nm s/rad
//   F_push          6      −F_n n in contact, 0 elsewhere                      N
//   F_ext           6      wrench of the environment on the tip                N, Nm
//   F_compliant     6      F_ext without what contact at the tip can explain, so that the pen
//                          yields to a hand but not to its own friction       N, Nm
//   r_y             n      unmodelled torque r of momentum_observer.h. Beyond  Nm
//                          observer.yield_limit + 0.12 |g| of a joint only its part
//                          at the tip: r_c + Jᵀ J̄ᵀ (r − r_c), r_c = r within
//   τ_limit         n      joint_range.torque ((margin − d)/margin)² away from the end of a joint's
//                          range, if its distance d is below the margin        Nm
//
// Without a measured wrench M_d must be Λ. F_act then needs no F_ext, and the actual F_ext replaces
// F_compliant in (1).
//
// In contact  e is the error of the ink, not of the tip, seen along the drawing axis z (13):
//             ErrorProjection. K has no normal part. z_E is aligned with −n, or with the plan's
//             axis (PenAxis); rotation about z_E is only damped.
// Carrier     A canvas that moves carries reference, surface and contact (moving_frame.h). In
//             contact the desired velocity along n is that of the carrier there, plus what the
//             tip's own motion in contact shows it to lack: the tip is the fastest sensor along n.
//             Friction acts against the velocity relative to the carrier.
// Roughness   Where a wrench is measured, the felt normal (felt_normal.h) corrects the perceived,
//             which n follows, tells where the tip's ball touches, and lessens the push along n so
//             that the force along the felt normal stays F_n.
// Modes       contact_mode.h. The desired force stays continuous at a mode switch: the difference
//             is carried over and decays with `switch_time`.
// Limits      V_d + B⁻¹ K e, the steady-state speed of spring and damper, is limited to
//             limits.tip_speed, limits.turn_speed and what moves no joint faster than
//             limits.joint_speed (Khatib's velocity saturation), less before the end of its range,
//             where it comes to rest: the pen turns less, then stops. A joint that is faster all
//             the same is damped. Torque and torque rate are limited last and preserve the task as
//             far as possible (torque_limits.h).
// Heading     The turn about the pen's axis is free. It is damped, and turns joints away that are
//             within joint_range.margin of their limits, as far as it moves them.
//
// Requires    M symmetric positive definite; vectors for the number of joints given at set-up;
//             n_WD and n_W of unit length; one call every timing.dt; J of full row rank. Near a
//             singularity the lost direction is released and `status.near_singular` is set.
// Errors      The constructor throws InputError. step() throws nothing, allocates nothing and
//             reports in `status`. For a stale or non-finite state it returns the last gravity
//             torque, approached within the rate limit. After a stale wrench the pen retreats from
//             the surface.
// Source      Equation numbers: C. Evagora, S. N. Iqbal, S. C. Feujó Nomeny, "Drawing With
//             Operation Space Impedance Control". Method: O. Khatib, "A unified approach for
//             motion and force control of robot manipulators: the operational space formulation",
//             IEEE J. Robotics and Automation 3(1), 1987.
#pragma once

#include <utility>

#include "impedraw/control/contact_mode.h"
#include "impedraw/control/damping.h"
#include "impedraw/control/felt_normal.h"
#include "impedraw/control/impedance_settings.h"
#include "impedraw/control/momentum_observer.h"
#include "impedraw/control/moving_frame.h"
#include "impedraw/control/normal_tracker.h"
#include "impedraw/control/surface_estimate.h"
#include "impedraw/control/tip_reference.h"
#include "impedraw/control/torque_limits.h"

namespace impedraw {

using Wrench = Vector6;  // [force; torque] at the origin of E, in W [N, Nm]

enum TorqueTerm {
  kFeedforward,      // Jᵀ Λ V̇_d and friction feedforward
  kImpedance,        // Jᵀ Λ M_d⁻¹ ( B (V_d − V) + K e )
  kPush,             // Jᵀ Λ M_d⁻¹ F_push
  kWrench,           // Jᵀ ( Λ M_d⁻¹ F_compliant − F_ext )
  kVelocityProduct,  // Jᵀ Λ ( J M⁻¹ C v − J̇v )
  kNullSpace,        // (I − Jᵀ J̄ᵀ) τ_null
  kGravity,          // g
  kDisturbance,      // −r_y
  kTorqueTerms
};
inline constexpr std::string_view kTorqueTermNames[] = {
    "feedforward",      "impedance",  "push",    "wrench",
    "velocity_product", "null_space", "gravity", "disturbance"};

// Age of a step's inputs beyond timing.loop_delay and timing.wrench_delay [s].
struct InputAges {
  double state = 0.0, wrench = 0.0;
};

struct ControlStatus {
  // An input is not finite or has the wrong size, M is not positive definite, or a normal is not of
  // unit length. The torque goes to the last gravity torque.
  bool bad_input = false;
  bool near_singular = false;   // a direction of the tip was released
  bool stale_state = false;     // older than timing.max_state_age; torque as for bad_input
  bool stale_wrench = false;    // older than timing.max_wrench_age; the pen leaves the surface
  bool torque_limited = false;  // a limit on torque or torque rate was active
  bool speed_limited = false;   // limits.tip_speed, turn_speed or joint_speed was active
  bool joint_limit = false;     // a joint is within joint_range.margin of its limit
  bool surface_lost = false;    // contact is desired but perception has no surface here
  bool damping_limit = false;  // M_d ∝ Λ: max eig(M_d⁻¹B)(Δt + delay) ≥ 0.5 in this posture
  bool ok() const {
    return !(bad_input || near_singular || stale_state || stale_wrench || torque_limited ||
             speed_limited || joint_limit || surface_lost || damping_limit);
  }
};

struct ImpedanceTorque {
  JointVector tau;  // after limits, n [Nm]
  // n × kTorqueTerms, one column per term. The columns sum to the torque before limits [Nm].
  Eigen::Matrix<double, Eigen::Dynamic, kTorqueTerms, Eigen::ColMajor, kMaxJoints, kTorqueTerms>
      terms;
  ContactMode mode = ContactMode::free;
  ControlStatus status;
  double push = 0.0;        // desired normal force [N]
  double rise = 0.0;        // of the surface along n, beyond the carrier's velocity there [m/s]
  double task_share = 1.0;  // s of torque_limits.h
  Eigen::Vector3d p_WD = Eigen::Vector3d::Zero();      // desired tip, compensation included [m]
  Eigen::Vector3d n_WD = Eigen::Vector3d::UnitZ();     // normal that the push follows
  Eigen::Vector3d axis_WD = Eigen::Vector3d::UnitZ();  // desired pen axis, outward: z_D = −axis_WD
};

class ImpedanceController {
 public:
  // Throws InputError as ImpedanceSettings::validate() does, and if a delay exceeds the observer's
  // history.
  ImpedanceController(const ImpedanceSettings& settings, int joints);

  // Computes one step. The result belongs to this object and is overwritten by the next step.
  // `reference`: the plan at this instant. `surface`: the estimate at the tip, with status `none`
  // if there is no perception; one that faces away from the plan, by more than 120°, is of a thin
  // body's other side, and is turned round. `F_ext` is used only with WrenchFeedback::measured.
  // `carrier`: how the canvas moves now; null: it stands. Reference and surface are given in W in
  // either case.
  const ImpedanceTorque& step(const ArmTerms& arm, const TipReference& reference,
                              const SurfaceEstimate& surface, const Wrench& F_ext,
                              const InputAges& ages = {},
                              const FrameMotion* carrier = nullptr) noexcept;

  // Takes the energy out of a motion that the law no longer controls, with nothing that the law
  // needs: no wrench, no observer, no shaped inertia. Then continue with step(), in mode free.
  //   τ = g + D (v_D − v) + K ∫(v_D − v) dt,   D and K diagonal
  //   D as high as a third of the damping criterion allows, and as the torque's rate can follow
  //   from 2 rad/s; K = D²/(4 M_jj)
  // v_D: zero, or the motion of least energy with the tip's velocity v_WD [m/s]. The integral holds
  // against friction and a hand.
  const ImpedanceTorque& brake(const ArmTerms& arm,
                               const Eigen::Vector3d& v_WD = Eigen::Vector3d::Zero()) noexcept;

  void reset() noexcept;  // restores the initial state: mode free, no carried force

  // Changes K and F_n of the law from the next step on, and B with them; the state is kept. Throws
  // InputError as the constructor does, and then changes nothing. Between steps, not within them.
  void retune(const TipGain& stiffness, double normal_force);

 private:
  // Reference of (1) in one step, in W.
  struct ReferenceMotion {
    Vector6 V_d, Vdot_d;
    Vector6 Ke;    // K e
    Vector6 push;  // F_push
  };
  using TaskTerms = Eigen::Matrix<double, 6, kVelocityProduct + 1>;  // one column per TorqueTerm

  ControlStatus input_status(const ArmTerms& arm, const TipReference& reference,
                             const SurfaceEstimate& surface, const Wrench& F_ext,
                             const InputAges& ages) const noexcept;
  const ImpedanceTorque& safe_torque() noexcept;
  void forget() noexcept;

  void update_mode(const TipReference& reference, const SurfaceEstimate& surface,
                   const Wrench& F_ext) noexcept;
  void update_force_integral(const Wrench& F_ext) noexcept;
  void update_damping() noexcept;
  void update_felt_normal(const ArmTerms& arm, const Wrench& F_ext) noexcept;

  ReferenceMotion reference_on_plan(const ArmTerms& arm, const TipReference& reference) noexcept;
  ReferenceMotion reference_on_surface(const ArmTerms& arm, const TipReference& reference,
                                       const SurfaceEstimate& surface) noexcept;
  void update_rise(const ArmTerms& arm) noexcept;
  // Of the carrier at p_W.
  Eigen::Vector3d carrier_velocity(const Eigen::Vector3d& p_W) const noexcept {
    return carrier_ ? carrier_->velocity_at(p_W) : Eigen::Vector3d(Eigen::Vector3d::Zero());
  }

  // Of damping, a third of what the sampled loop bears [1/s].
  double bearable_rate() const noexcept {
    return kDampingLimit / 3.0 / settings_.timing.damping_delay();
  }
  Vector6 damp(const Vector6& V) const noexcept;
  std::pair<double, double> into_margins(const JointVector& q, int j) const noexcept;
  double heading_rate(const ArmTerms& arm) const noexcept;
  Vector6 spring_and_damper(const ArmTerms& arm, ReferenceMotion* desired) noexcept;
  Vector6 handed_over(const Vector6& force, const Vector6& push) noexcept;
  Eigen::Vector3d slip(const ArmTerms& arm) const noexcept;
  Wrench tip_contact(const ArmTerms& arm, const Wrench& F_ext) const noexcept;
  Eigen::Vector3d foreseen_friction(const ArmTerms& arm, const Vector6& V_d) const noexcept;
  void apply_inertia(TaskTerms* F) const noexcept;

  JointVector null_space_torque(const ArmTerms& arm) noexcept;
  JointVector limit_repulsion(const JointVector& q) noexcept;
  JointVector disturbance(const ArmTerms& arm, const Wrench& F_ext) noexcept;
  double most_joint_speed(const ArmTerms& arm, Eigen::Index j, double v) const noexcept;
  void keep_joint_speeds(const ArmTerms& arm, Vector6* V) const noexcept;
  JointVector too_fast(const ArmTerms& arm) noexcept;
  void apply_limits(const ArmTerms& arm) noexcept;
  JointVector brake_torque(const ArmTerms& arm, const JointVector& lack) const noexcept;

  ImpedanceSettings settings_;  // completed
  TipGain K_damping_;           // K'
  bool shaped_, measured_, observed_;
  double scale_;       // c of M_d = c Λ
  double side_force_;  // tan δ: of a wrong normal, per f_n
  JointVector q_0_, null_stiffness_, lower_, upper_;
  JointVector yield_limit_;  // of r; empty: none
  OperationalSpace space_;
  ModalDamping modal_damping_;
  TipGain shaped_damping_;
  MomentumObserver observer_;
  TorqueLimits limits_;
  NormalTracker tracker_;
  FeltNormal felt_;
  Eigen::Vector3d n_C_ = Eigen::Vector3d::UnitZ();  // normal where the tip touches
  ContactStates contact_;
  bool force_from_zero_ = false;  // the desired force starts from zero
  bool on_surface_ = false;       // the last step used the law for approach and contact
  ContactMode last_mode_ = ContactMode::free;
  double force_integral_ = 0.0;           // [N]
  const FrameMotion* carrier_ = nullptr;  // of this step
  double rise_ = 0.0;  // of the surface along n in contact, beyond the carrier's velocity [m/s]
  double approach_distance_ = 0.0;  // desired distance to the surface during the approach [m]
  Vector6 carried_force_ = Vector6::Zero();  // carried over at the last switch, decaying
  Vector6 last_force_ = Vector6::Zero();     // force + push of the last step
  JointVector behind_;                       // ∫(v_D − v) dt of brake() [rad]
  bool braked_ = false;                      // by the last call
  ImpedanceTorque out_;
};

}  // namespace impedraw
