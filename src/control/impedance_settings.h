// Every setting of the impedance controller, with its unit; check_settings.h has what is valid.
// Vectors have an entry a joint: their defaults are those of an arm of seven. Gains stand in the
// surface frame S (z = n); "tangent" holds for both tangents.
#pragma once

#include "impedraw/control/axial_gain.h"
#include "impedraw/control/contact_mode.h"
#include "impedraw/control/momentum_observer.h"
#include "impedraw/control/operational_space.h"

namespace impedraw {

enum class InertiaShaping {
  natural,  // M_d = Λ: the arm keeps the inertia it has. The only choice without a measured wrench.
  scaled,   // M_d = c Λ
  shaped,   // M_d = diag(mass, inertia) in S, constant
};

enum class WrenchFeedback {
  none,      // F_ext is not known
  measured,  // F_ext is given at each step, taken at E, in W
};

// How the position error of (13) comes onto the tangent plane, seen along the drawing axis z
// (drawing_axis_W).
enum class ErrorProjection {
  lifted,  // e − z (n·e)/(n·z): same fixed point, full stiffness on any slope
  paper,   // (z × e) × z, then K in S: cos²θ of the stiffness up and down a slope θ
};

// An integral of the force error, for what stays of it: slow, bounded, held while a torque is
// limited, gone out of contact.
struct ForceIntegralSettings {
  bool enabled = false;
  double rate = 2.0;   // of push per force error [1/s]
  double limit = 2.0;  // of what it adds to the push, ± [N]
};

struct ImpedanceSettings {
  double dt = 1e-3;            // step [s]
  double loop_delay = 1e-3;    // age of the state when the torque acts [s]
  double wrench_delay = 1e-3;  // and of F_ext, which is at least the mean over the step before [s]

  InertiaShaping inertia = InertiaShaping::shaped;
  WrenchFeedback wrench = WrenchFeedback::measured;
  ErrorProjection projection = ErrorProjection::lifted;

  TipGain stiffness{
      {3000.0, 1500.0},
      {100.0, 0.0}};  // K: [N/m], [Nm/rad]. The normal one holds in free motion and approach only
  TipGain reference_stiffness{{0.0, 1500.0}, {0.0, 10.0}};  // K' where K is zero: sizes the damping
  TipGain shaped_inertia{{4.0, 3.0}, {0.05, 0.02}};         // M_d if shaped: [kg], [kg m²]
  double inertia_scale = 1.0;                               // c, M_d if scaled
  double damping_ratio = 0.8;                               // ζ

  double normal_force = 5.0;     // F_n [N]
  double switch_time = 0.04;     // time constant in which a switch of mode hands over force [s]
  double approach_speed = 0.01;  // along −n [m/s]
  // how far beneath the estimated surface the approach goes on [m]
  double approach_overtravel = 4.0e-3;
  double approach_lag = 2.0e-3;    // the approach waits for a tip that is held back by more [m]
  double retreat_height = 0.02;    // above the plan, after the surface was lost [m]
  double normal_bandwidth = 40.0;  // of the tracker of the surface normal [rad/s]
  Eigen::Vector3d drawing_axis_W = Eigen::Vector3d::UnitZ();  // z: unit, out of the drawing plane
  double min_axis_cosine = 0.2;  // least |n·z| at which an error is lifted along z

  double tip_radius = 1.0e-3;  // of the pen's tip sphere [m]
  // believed, along the normal [N/m]; 0: rigid. Takes out the ink's shift by the tip's give
  double tip_stiffness = 20.0e3;
  double friction = 0.3;  // μ̂: what of the measured wrench tip friction may explain; 0: nothing
  // μ̂ for use without a measured wrench: friction foreseen along the stroke; 0: none
  double friction_feedforward = 0.0;
  double friction_speed = 2.0e-3;  // below it the friction's direction fades [m/s]

  ObserverSettings observer;  // of what the model misses
  // of the arm's drives, as the observer believes: a command acts that much later [s]
  double torque_delay = 0.0;
  ForceIntegralSettings force_integral;

  // What the normal loop is checked against at set-up.
  double contact_stiffness_max = 50.0e3;  // [N/m]
  double natural_mass_max = 10.0;         // Λ along the normal [kg]

  ContactSettings contact;
  OperationalSpaceSettings operational_space;

  Eigen::VectorXd null_stiffness = Eigen::VectorXd::Constant(7, 10.0);  // K_q [Nm/rad]
  double null_damping_ratio = 0.7;                                   // D_q = 2 ζ √(K_q diag(M))
  Eigen::VectorXd q_0 = Eigen::VectorXd::Zero(7);                    // rest posture (14) [rad]
  Eigen::VectorXd torque_limit = Eigen::VectorXd::Constant(7, 1e3);  // ± [Nm]
  Eigen::VectorXd torque_rate_limit;                                 // ± [Nm/s]; empty: none
  Eigen::VectorXd joint_lower, joint_upper;  // joint range [rad]; empty: none
  double limit_margin = 0.15;  // so near to a joint's limit the null space pushes back [rad] ...
  double limit_torque = 30.0;  // ... with this at the limit, growing on beyond it [Nm]

  double tip_speed_limit = 0.6;  // of the speed that the law asks for [m/s]
  double max_state_age = 5e-3;   // older input is stale [s]
  double max_wrench_age = 2e-2;  // [s]
};

}  // namespace impedraw
