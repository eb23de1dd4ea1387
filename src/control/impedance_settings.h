// Settings of the impedance controller, in small groups. The law that they belong to: impedance.h.
//
// Gains   stand in the surface frame S, z = n, and are the same along both tangents (axial_gain.h)
// Joints  a vector has one entry per joint, for any number of joints; an empty one stands for the
//         default beside it
// Errors  validate() throws InputError, which names the setting, its value and what is valid
#pragma once

#include "impedraw/control/axial_gain.h"
#include "impedraw/control/contact_mode.h"
#include "impedraw/control/momentum_observer.h"
#include "impedraw/control/operational_space.h"

namespace impedraw {

enum class InertiaShaping {
  natural,  // M_d = Λ: the arm keeps its inertia. The only choice without a measured wrench.
  scaled,   // M_d = c Λ
  shaped,   // M_d = diag(mass, inertia) in S, constant
};

enum class WrenchFeedback {
  none,      // F_ext is not known
  measured,  // F_ext is given at each step, taken at E, in W
};

// How the position error of (13), seen along the drawing axis z, comes onto the tangent plane.
enum class ErrorProjection {
  lifted,  // e − z (n·e)/(n·z): same fixed point, full stiffness on any slope
  paper,   // (z × e) × z, then K in S: cos²θ of the stiffness up and down a slope θ
};

// How late the inputs and the torque are. Stability is checked against these delays, and the
// momentum observer puts torque and wrench beside the motion that they belong to.
struct TimingSettings {
  double dt = 1e-3;  // step [s]
  // Greatest age of the state while the torque computed from it acts [s]: one step where a torque
  // acts at once and until the next one, d more where drives and communication take d.
  double loop_delay = 1e-3;
  // Age of F_ext as it is given, at least one step: a mean over the step before [s].
  double wrench_delay = 1e-3;
  double max_state_age = 5e-3;   // an older state is stale: InputAges::state [s]
  double max_wrench_age = 2e-2;  // an older wrench is stale: InputAges::wrench [s]

  // What the torque is late beyond the step that every sampled loop has [s].
  double torque_delay() const { return loop_delay > dt ? loop_delay - dt : 0.0; }
};

// How the estimated surface enters the law.
struct SurfaceSettings {
  ErrorProjection projection = ErrorProjection::lifted;
  Eigen::Vector3d drawing_axis_W = Eigen::Vector3d::UnitZ();  // z, unit, out of the drawing plane
  double min_axis_cosine = 0.2;    // least |n·z| at which an error is lifted along z
  double normal_bandwidth = 40.0;  // of the tracker of the surface normal [rad/s]
};

// The way down to the surface, and away from it.
struct ApproachSettings {
  double speed = 0.01;           // along −n [m/s]
  double overtravel = 4.0e-3;    // the approach ends this far beneath the estimated surface [m]
  double lag = 2.0e-3;           // the approach waits for a tip that is held back by more [m]
  double retreat_height = 0.02;  // above the plan, after surface or wrench were lost [m]
};

// The pen's tip, as believed.
struct TipSettings {
  double radius = 1.0e-3;  // of the tip sphere [m]
  // Along the normal [N/m]; 0: rigid. Takes out the shift of the ink by the tip's give.
  double stiffness = 20.0e3;
};

// Friction at the tip, as believed.
struct FrictionSettings {
  double coefficient = 0.3;    // μ̂: the part of a measured wrench that tip friction can explain
  double feedforward = 0.0;    // μ̂ without a measured wrench: friction foreseen along the stroke
  double fade_speed = 2.0e-3;  // below it the direction of friction fades [m/s]
};

// An integral of the force error: slow, bounded, held while a torque is limited, zero out of
// contact.
struct ForceIntegralSettings {
  bool enabled = false;  // needs a measured wrench
  double rate = 2.0;     // of push per force error [1/s]
  double limit = 2.0;    // of what it adds to the push, ± [N]
};

// The stiffest contact and the largest natural mass for which the force loop is checked at set-up.
struct StabilityCheckSettings {
  double contact_stiffness_max = 50.0e3;  // [N/m]
  double natural_mass_max = 10.0;         // Λ along the normal [kg]
};

// τ_null = K_q (q_0 − q) − D_q v + τ_limit. An arm of six joints has no null space: it feels none
// of this.
struct NullSpaceSettings {
  Eigen::VectorXd stiffness;   // K_q [Nm/rad]; empty: 10 Nm/rad on each joint
  double damping_ratio = 0.7;  // ζ of D_q = 2 ζ √(K_q diag(M))
  // Rest posture (14) [rad]; empty: the middle of each joint's range, 0 where there is none.
  Eigen::VectorXd q_0;
};

// Joint range. Near its ends τ_limit pushes a joint back, in the null space.
struct JointRangeSettings {
  Eigen::VectorXd lower, upper;  // [rad]; empty: none. Both or neither
  double margin = 0.15;          // nearer to the end than this, the joint is pushed back [rad]
  double torque = 30.0;          // of that push at the end of the range, growing beyond it [Nm]
};

// What the controller never asks for.
struct LimitSettings {
  Eigen::VectorXd torque;       // ± [Nm]; empty: 1000 Nm on each joint
  Eigen::VectorXd torque_rate;  // ± [Nm/s]; empty: none
  double tip_speed = 0.6;       // of the speed that the law asks for [m/s]
};

struct ImpedanceSettings {
  TimingSettings timing;

  // Desired dynamics (1): M_d, B, K.
  InertiaShaping inertia = InertiaShaping::shaped;
  WrenchFeedback wrench = WrenchFeedback::measured;
  // K: [N/m], [Nm/rad]. Its linear normal part holds in free motion and approach only.
  TipGain stiffness{{3000.0, 1500.0}, {100.0, 0.0}};
  // Sizes the damping of an axis whose stiffness is zero: [N/m], [Nm/rad].
  TipGain reference_stiffness{{0.0, 1500.0}, {0.0, 10.0}};
  TipGain shaped_inertia{{4.0, 3.0}, {0.05, 0.02}};  // M_d if shaped: [kg], [kg m²]
  double inertia_scale = 1.0;                        // c of M_d = c Λ if scaled
  double damping_ratio = 0.8;                        // ζ of every mode

  double normal_force = 5.0;  // F_n, in contact [N]
  double switch_time = 0.04;  // time constant in which a switch of mode hands over force [s]

  SurfaceSettings surface;
  ApproachSettings approach;
  ContactSettings contact;
  TipSettings tip;
  FrictionSettings friction;
  ObserverSettings observer;
  ForceIntegralSettings force_integral;
  StabilityCheckSettings stability_check;
  OperationalSpaceSettings operational_space;
  NullSpaceSettings null_space;
  JointRangeSettings joint_range;
  LimitSettings limits;

  // K' of damping.h: the stiffness, or the reference stiffness along an axis that has none.
  TipGain damping_stiffness() const;

  // Throws InputError naming the first setting found wrong, its value and what is valid: a number
  // out of range, a vector without one entry per joint, a shaped or scaled inertia without a
  // measured wrench or beyond what the sampled, delayed loop can hold (contact_stability.h).
  // joints: 1 to kMaxJoints; a task of six axes needs six.
  void validate(int joints) const;

  // The same settings with every empty vector replaced by its default, those that stand for no
  // limit excepted.
  ImpedanceSettings completed(int joints) const;
};

}  // namespace impedraw
