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
//   V_d, V̇_d, e     6      desired motion and its error: tip_target.h          m/s, m/s², m, rad
//   M_d, B, K       6×6    inertia, damping and stiffness: tip_impedance.h     kg, N s/m, N/m, …
//   F_push          6      −F_n n in contact, 0 elsewhere: normal_push.h       N
//   F_ext           6      wrench of the environment on the tip                N, Nm
//   F_compliant     6      F_ext without what contact at the tip can explain   N, Nm
//                          (tip_friction.h), so that the pen yields to a hand but not to its own
//                          friction
//   r_y             n      unmodelled torque: disturbance.h                    Nm
//   τ_null          n      motion of the arm within itself: null_space.h       Nm
//
// Without a measured wrench M_d must be Λ. F_act then needs no F_ext, and the actual F_ext replaces
// F_compliant in (1).
//
// In the order of a step, each in a file of its own with its law:
//   contact.h        mode and normal n of the contact, the rise of a surface that moves
//   tip_impedance.h  M_d, B and K for this posture
//   tip_target.h     V_d, V̇_d, K e on the plan or on the surface
//   normal_push.h    F_push with its slow integral
//   heading.h        turns the pen about its axis: free, away from the ends of ranges, or led
//   speed_limit.h    tip, turn and joint speeds (Khatib's velocity saturation)
//   handover.h       keeps the force continuous at a switch of the mode
//   null_space.h, disturbance.h, joint_damper.h
//   torque_limits.h  torque and torque rate, last; they preserve the task as far as possible
// and joint_brake.h, the second law, of brake().
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

#include "impedraw/control/contact.h"
#include "impedraw/control/disturbance.h"
#include "impedraw/control/handover.h"
#include "impedraw/control/hurried_torque.h"
#include "impedraw/control/joint_brake.h"
#include "impedraw/control/joint_damper.h"
#include "impedraw/control/joint_range.h"
#include "impedraw/control/normal_push.h"
#include "impedraw/control/null_space.h"
#include "impedraw/control/speed_limit.h"
#include "impedraw/control/step_input.h"
#include "impedraw/control/stiff_contact.h"
#include "impedraw/control/tip_friction.h"
#include "impedraw/control/tip_impedance.h"
#include "impedraw/control/tip_target.h"
#include "impedraw/control/torque_limits.h"

namespace impedraw {

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

  // Λ and the factors of M at the last step's terms; null where the step had to do without.
  const OperationalSpace* space() const noexcept {
    return out_.status.bad_input || out_.status.stale_state ? nullptr : &space_;
  }

  void reset() noexcept;  // restores the initial state: mode free, no carried force

  // Changes K and F_n of the law from the next step on, and B with them; the state is kept. Throws
  // InputError as the constructor does, and then changes nothing. Between steps, not within them.
  void retune(const TipGain& stiffness, double normal_force);
  // Changes the radius of the tip's ball, from the next step on [m].
  void set_tip_radius(double radius) noexcept { settings_.tip.radius = radius; }

 private:
  const ImpedanceTorque& hold_with_gravity() noexcept;
  const ImpedanceTorque& publish(const LimitedTorque& limited) noexcept;
  void publish(const Contact& contact, const TipTarget& target, double push) noexcept;
  void forget(bool from_zero) noexcept;

  ImpedanceSettings settings_;  // completed
  bool measured_;
  OperationalSpace space_;
  JointRange range_;
  SurfaceContact contact_;
  TipImpedance impedance_;
  StiffContact stiff_contact_;
  HurriedTorque hurried_torque_;
  NormalPush push_;
  TipFriction friction_;
  SpeedLimit speed_limit_;
  Handover handover_;
  NullSpace null_space_;
  JointDamper joint_damper_;
  Disturbance disturbance_;
  TorqueLimits limits_;
  JointBrake brake_;
  ImpedanceTorque out_;
};

}  // namespace impedraw
