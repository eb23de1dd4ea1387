// Settings of the impedance controller, in groups. The control law is in impedance.h.
//
// Gains   are given in the surface frame S, z = n, and are equal along both tangents (axial_gain.h)
// Joints  a vector has one entry per joint; an empty vector selects the stated default
// Errors  validate() throws InputError, which names the setting, its value and what is valid
#pragma once

#include "impedraw/control/axial_gain.h"
#include "impedraw/control/contact_mode.h"
#include "impedraw/control/felt_normal.h"
#include "impedraw/control/momentum_observer.h"
#include "impedraw/control/operational_space.h"

namespace impedraw {

enum class InertiaShaping {
  natural,  // M_d = Λ: the arm keeps its inertia; required without a measured wrench
  scaled,   // M_d = c Λ
  shaped,   // M_d = diag(mass, inertia) in S, constant
  light_normal,  // M_d = S Λ S, S = I − (1 − √c) n nᵀ: natural, but lighter where the pen pushes
};

enum class WrenchFeedback {
  none,      // F_ext is unknown
  measured,  // F_ext is given at each step, taken at E, in W
};

// Projection of the position error (13) along the drawing axis z onto the tangent plane.
enum class ErrorProjection {
  lifted,  // e − z (n·e)/(n·z): same fixed point, full stiffness on any slope
  paper,   // (z × e) × z, then K in S: cos²θ of the stiffness up and down a slope θ
};

// Direction of the pen's axis in approach and contact. The push is along the estimated normal
// either way.
enum class PenAxis {
  surface,  // along the estimated normal at the tip
  plan,     // along the plan's: a rough surface does not shake the wrist
};

// Delays of inputs and torque. The stability check uses them, and the momentum observer aligns
// torque and wrench with the motion that they belong to.
struct TimingSettings {
  double dt = 1e-3;  // step [s]
  // Greatest age of the state while the torque computed from it acts [s]: one step if the torque
  // acts immediately and until the next one, plus the delay of drives and communication, which a
  // scenario gives (control.torque_delay, arm.delay).
  double loop_delay = 1e-3;
  // Age of F_ext as passed to step() [s]. At least one step, as F_ext is a mean over the last step.
  double wrench_delay = 1e-3;
  // Age of v as passed to step(), filters included; 0 if it was forecast to now [s].
  double velocity_age = 0.0;
  // Lag of an estimated v to what its model does not explain; for the stability checks [s].
  double velocity_lag = 0.0;
  double max_state_age = 5e-3;   // an older state is stale: InputAges::state [s]
  double max_wrench_age = 2e-2;  // an older wrench is stale: InputAges::wrench [s]

  // Delay of the torque beyond the one step that every sampled loop has [s].
  double torque_delay() const { return loop_delay > dt ? loop_delay - dt : 0.0; }
  // Time from a motion until damping acts on it, for the stability checks [s].
  double damping_delay() const { return dt + loop_delay + velocity_age + velocity_lag; }
};

// Use of the estimated surface in the law.
struct SurfaceSettings {
  ErrorProjection projection = ErrorProjection::lifted;
  Eigen::Vector3d drawing_axis_W = Eigen::Vector3d::UnitZ();  // z, unit, out of the drawing plane
  double min_axis_cosine = 0.2;  // |n·z| below which the plan's own height begins to count
  PenAxis pen_axis = PenAxis::surface;
  // Bandwidth of the tracker of the surface normal, which does not lag along a stroke [rad/s].
  double normal_bandwidth = 40.0;
};

// Motion towards the surface and away from it.
struct ApproachSettings {
  double speed = 0.01;         // along −n [m/s]
  double overtravel = 4.0e-3;  // the approach ends this far beneath the estimated surface [m]
  // The approach waits if the tip lags by more than this: half of overtravel [m].
  double lag = 2.0e-3;
  double retreat_height = 0.02;  // above the plan, after surface or wrench is lost [m]
};

// Model of the pen tip.
struct TipSettings {
  double radius = 1.0e-3;  // of the tip sphere [m]
  // Along the normal [N/m]; 0: rigid. Compensates the shift of the ink by the tip's compression.
  double stiffness = 20.0e3;
};

// The share that contact at the tip may add to a measured wrench besides the force along n.
struct FrictionSettings {
  double coefficient = 0.3;  // μ̂ for the part of a measured wrench that friction can explain
  // The estimated normal may err by this angle: the surface then pushes the tip aside by f_n times
  // its tangent [deg].
  double normal_error_deg = 0.0;
  double feedforward = 0.0;    // μ̂ of the feedforward used without a measured wrench
  double fade_speed = 2.0e-3;  // friction fades out below this speed [m/s]
};

// Slow, bounded integral of the force error. It is frozen while a torque is limited and zero out of
// contact.
struct ForceIntegralSettings {
  bool enabled = false;  // needs a measured wrench
  double rate = 2.0;     // of push per force error [1/s]: slow beside the contact's bandwidth
  double limit = 2.0;    // of its contribution to the push, ± [N]
};

// Stiffest contact and largest natural mass for which set-up checks the force loop.
struct StabilityCheckSettings {
  double contact_stiffness_max = 50.0e3;  // [N/m]
  double natural_mass_max = 10.0;         // Λ along the normal [kg]
};

// τ_null = K_q (q_0 − q) − D_q v + τ_limit. No effect on an arm of six joints, which has no null
// space.
struct NullSpaceSettings {
  Eigen::VectorXd stiffness;   // K_q [Nm/rad]; empty: 10 Nm/rad on each joint
  double damping_ratio = 0.7;  // ζ of D_q = 2 ζ √(K_q diag(M)): overshoot of 5 % of a step
  // Rest posture (14) [rad]; empty: the middle of each joint's range, 0 for a joint without a range
  Eigen::VectorXd q_0;
};

// Joint range. Near its ends τ_limit pushes the joint back, in the null space.
struct JointRangeSettings {
  Eigen::VectorXd lower, upper;  // [rad]; empty: no limits; give both or neither
  double margin = 0.15;          // distance from the end at which τ_limit starts [rad]
  double torque = 30.0;          // τ_limit at the end of the range; it grows beyond [Nm]
};

// Limits on commanded torque and on the tip's speed and turning.
struct LimitSettings {
  Eigen::VectorXd torque;       // ± [Nm]; empty: 1000 Nm on each joint
  Eigen::VectorXd torque_rate;  // ± [Nm/s]; empty: none
  // ± that V_d + B⁻¹ K e may ask for, and above which a joint is damped [rad/s]; empty: none
  Eigen::VectorXd joint_speed;
  double tip_speed = 0.6;   // of V_d + B⁻¹ K e, linear part [m/s]
  double turn_speed = 4.0;  // of its angular part [rad/s]
};

struct ImpedanceSettings {
  TimingSettings timing;

  // Desired dynamics (1): M_d, B, K.
  InertiaShaping inertia = InertiaShaping::shaped;
  WrenchFeedback wrench = WrenchFeedback::measured;
  // K: [N/m], [Nm/rad]. Its linear normal part applies only in free motion and approach.
  TipGain stiffness{{5000.0, 1500.0}, {60.0, 0.0}};
  // Determines the damping of an axis with zero stiffness: [N/m], [Nm/rad].
  TipGain reference_stiffness{{0.0, 1500.0}, {0.0, 10.0}};
  TipGain shaped_inertia{{4.0, 1.5}, {0.05, 0.02}};  // M_d if shaped: [kg], [kg m²]
  double inertia_scale = 1.0;  // c of M_d = c Λ if scaled, of S if light_normal
  double damping_ratio = 0.8;  // ζ of every mode

  double normal_force = 5.0;  // F_n, in contact [N]
  double switch_time = 0.04;  // time constant of the force carried over at a mode switch [s]

  SurfaceSettings surface;
  ApproachSettings approach;
  ContactSettings contact;
  TipSettings tip;
  FrictionSettings friction;
  FeltNormalSettings felt_normal;
  ObserverSettings observer;
  ForceIntegralSettings force_integral;
  StabilityCheckSettings stability_check;
  OperationalSpaceSettings operational_space;
  NullSpaceSettings null_space;
  JointRangeSettings joint_range;
  LimitSettings limits;

  // K' of damping.h: the stiffness, or the reference stiffness for an axis with zero stiffness.
  TipGain damping_stiffness() const;

  // Each throws InputError naming the first invalid setting, its value and what is valid.
  // validate_ranges: a number out of range, or a vector without one entry per joint.
  // validate_inertia: a shaped or scaled inertia that lacks a measured wrench or makes the sampled,
  // delayed loop unstable (contact_stability.h). Requires valid ranges.
  // joints: 1 to kMaxJoints; the six-axis task needs at least six.
  void validate_ranges(int joints) const;
  void validate_inertia() const;
  void validate(int joints) const;  // both

  // Returns these settings with every empty vector replaced by its default, except vectors that are
  // empty to mean no limit.
  ImpedanceSettings completed(int joints) const;
};

}  // namespace impedraw
