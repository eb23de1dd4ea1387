// Description of the impedance controller's settings (impedance_settings.h).
// describe(f, settings) names each number with its range and unit, and each setting of a scenario
// with a sentence on it; a constant is what no scenario sets. It is read by RangeChecks
// (common/range_check.h) and by Fields (settings/schema.h).
#pragma once

#include "impedraw/common/range.h"
#include "impedraw/control/impedance_settings.h"

namespace impedraw {

inline constexpr Range kMassRange = Range::positive_to(1000.0);  // [kg]
inline constexpr Range kFrictionRange{0.0, 3.0};                 // coefficient
inline constexpr Range kForceRange{0.0, 50.0};                   // of the push [N]
inline constexpr Range kNormalErrorRange{0.0, 75.0};             // [deg]
inline constexpr Range kNullStiffnessRange{0.0, 500.0};          // [Nm/rad]
inline constexpr Range kTorqueRateRange{1.0, 1e6};               // [Nm/s]

// The share may be optional.
template <class F, class S>
void describe_felt_normal(F& f, S& s) {
  f.field("share", s.share, {0.0, 1.0}, "",
          "Of the felt normal, beyond the deviation, in the normal that the law follows. 0: the "
          "force tells nothing of the surface. null: 0, but 0.5 under a pad, and where the surface "
          "under the drawing is rough.");
  f.constant("deviation", s.deviation, {0.0, 2.0}, "");
  f.constant("force_error", s.force_error, {0.0, 50.0}, "N");
}

template <class F>
void describe(F& f, ContactSettings& s) {
  f.constant("enter_distance", s.enter_distance, {0.0, 0.05}, "m");
  f.constant("search_distance", s.search_distance, {0.0, 0.05}, "m");
  f.constant("first_search_distance", s.first_search_distance, {0.0, 0.05}, "m");
  f.constant("leave_distance", s.leave_distance, Range::positive_to(0.1), "m");
  f.field("touch_force", s.touch_force, {0.0, 50.0}, "N",
          "Measured normal force above which the pen touches.");
  f.constant("touch_gap", s.touch_gap, {1e-5, 0.02}, "m");
  f.constant("loss_force", s.loss_force, {0.0, 50.0}, "N");
  f.constant("loss_time", s.loss_time, {0.0, 5.0}, "s");
  f.constant("lost_surface_time", s.lost_surface_time, {0.0, 5.0}, "s");
}

// The bandwidth may be optional.
template <class F, class Bandwidth>
void describe_observer(F& f, ObserverSettings& s, Bandwidth& bandwidth) {
  f.field("enabled", s.enabled, "Uses the observer. It needs a measured wrench.");
  f.field("bandwidth", bandwidth, {1.0, 900.0}, "rad/s",
          "Bandwidth of the observer's low-pass filter. null: 200 rad/s, but 600 rad/s for a "
          "simulated arm whose description has dry friction.");
  f.constant("limit", s.limit, {0.0, 1000.0}, "Nm");
  f.field(
      "yield_limit", s.yield_limit, {0.0, 1000.0}, "Nm",
      "Torque of each joint above which, and above 12 % of its weight torque on top, the observer "
      "compensates only what would move the tip, so that the arm yields to a push on its body; "
      "empty: 0.5 % of the joint's torque limit, at least 1.5 Nm.");
}
template <class F>
void describe(F& f, ObserverSettings& s) {
  describe_observer(f, s, s.bandwidth);
}

template <class F>
void describe(F& f, ForceIntegralSettings& s) {
  f.field("enabled", s.enabled, "Uses the integral. It needs a measured wrench.");
  f.constant("rate", s.rate, {0.01, 50.0}, "1/s");
  f.constant("limit", s.limit, {0.0, 50.0}, "N");
}

template <class F>
void describe(F& f, ImpedanceSettings& s) {
  f.choice("inertia", s.inertia, {"natural", "scaled", "shaped", "light_normal"},
           "Desired inertia M_d: the arm's own, a multiple of it, or the constant one set below.");
  f.choice("projection", s.surface.projection, {"lifted", "paper"},
           "Projection of the position error in contact, equation (13): with full stiffness on any "
           "slope, or as in the paper.");
  constexpr Range kLinear{0.0, 20000.0}, kAngular{0.0, 1000.0};
  f.field("stiffness_tangent", s.stiffness.linear.tangent, kLinear, "N/m",
          "Stiffness K along both tangents of the surface.");
  f.field("stiffness_normal", s.stiffness.linear.normal, kLinear, "N/m",
          "Stiffness K along the surface normal.");
  f.field("rotational_stiffness_tangent", s.stiffness.angular.tangent, kAngular, "Nm/rad",
          "Stiffness K about both tangents of the surface.");
  f.constant("rotational_stiffness_normal", s.stiffness.angular.normal, kAngular, "Nm/rad");
  f.constant("reference_stiffness_tangent", s.reference_stiffness.linear.tangent, kLinear, "N/m");
  f.constant("reference_stiffness_normal", s.reference_stiffness.linear.normal, kLinear, "N/m");
  f.constant("reference_rotational_stiffness_tangent", s.reference_stiffness.angular.tangent,
             kAngular, "Nm/rad");
  f.field("reference_rotational_stiffness_normal", s.reference_stiffness.angular.normal, kAngular,
          "Nm/rad",
          "Stiffness K' that sets the damping where K is zero, about the surface normal.");
  f.constant("mass_tangent", s.shaped_inertia.linear.tangent, kMassRange, "kg");
  f.constant("rotational_inertia_tangent", s.shaped_inertia.angular.tangent,
             Range::positive_to(100.0), "kg m²");
  f.constant("rotational_inertia_normal", s.shaped_inertia.angular.normal,
             Range::positive_to(100.0), "kg m²");
  f.field(
      "inertia_scale", s.inertia_scale, {0.01, 100.0}, "",
      "Desired inertia as a multiple of the arm's own, for inertia: scaled; for light_normal along "
      "the surface normal alone, or as light as the loop is stable with.");
  f.field("damping_ratio", s.damping_ratio, {0.05, 3.0}, "", "Damping ratio of every mode.");
  f.field("normal_force", s.normal_force, kForceRange, "N",
          "Normal force that the pen presses with while drawing.")
      .for_users()
      .formerly("push");
  f.constant("switch_time", s.switch_time, {0.001, 5.0}, "s");
  f.field("approach_speed", s.approach.speed, {1e-4, 0.2}, "m/s",
          "Speed along the normal until the pen touches.");
  f.constant("approach_overtravel", s.approach.overtravel, {0.0, 0.5}, "m");
  f.constant("approach_lag", s.approach.lag, {1e-4, 0.05}, "m");
  f.constant("retreat_height", s.approach.retreat_height, {0.0, 0.5}, "m");
  f.constant("normal_bandwidth", s.surface.normal_bandwidth, {1.0, 500.0}, "rad/s");
  f.field("tip_radius", s.tip.radius, {0.0, 0.05}, "m", "Modelled radius of the tip.");
  f.field("tip_stiffness", s.tip.stiffness, {0.0, 1e7}, "N/m",
          "Modelled stiffness of the tip along the normal; 0: rigid.");
  f.field("friction", s.friction.coefficient, kFrictionRange, "",
          "Modelled coefficient of friction: the part of a measured wrench that tip friction can "
          "explain.");
  f.field("friction_feedforward", s.friction.feedforward, {0.0, 3.0}, "",
          "Modelled coefficient of friction that is compensated along a stroke without a measured "
          "wrench.");
  f.field("contact_stiffness_max", s.stability_check.contact_stiffness_max, {1.0, 1e7}, "N/m",
          "Stiffest contact of tip and canvas in the stability check at set-up.");
  f.constant("natural_mass_max", s.stability_check.natural_mass_max, {0.1, 1000.0}, "kg");
  f.constant("null_damping_ratio", s.null_space.damping_ratio, {0.0, 3.0}, "");
  // up to the longest delay of the drives, and one step
  f.constant("loop_delay", s.timing.loop_delay, {0.0, 0.021}, "s");
  f.field("force_integral", s.force_integral, "Integral of the force error along the normal.");
  f.constant("limit_margin", s.joint_range.margin, {0.001, 1.0}, "rad");
  f.constant("limit_torque", s.joint_range.torque, {0.0, 300.0}, "Nm");
  f.field("tip_speed_limit", s.limits.tip_speed, {0.001, 5.0}, "m/s",
          "Largest tip speed that the control law may ask for.");
  f.field("turn_speed_limit", s.limits.turn_speed, {0.01, 50.0}, "rad/s",
          "Largest angular speed of the pen's axis that the control law may ask for.");
  f.constant("max_state_age", s.timing.max_state_age, {0.0, 1.0}, "s");
  f.constant("max_wrench_age", s.timing.max_wrench_age, {0.0, 1.0}, "s");
  f.field("contact", s.contact, "When contact begins and ends.");
}

}  // namespace impedraw
