// The settings of a scenario under `control`.
#include "impedraw/experiment/scenario.h"

namespace impedraw {
namespace {

// "Stiffness K along both tangents." and "... along the normal.", or about them.
void describe_axial(Fields& f, const Limit& limit, AxialGain& gain, const std::string& help) {
  const std::string name(limit.name), unit(limit.unit);
  f.field(name + "_tangent", gain.tangent, limit.range, unit,
          help + " both tangents of the surface.");
  f.field(name + "_normal", gain.normal, limit.range, unit, help + " the surface normal.");
}

}  // namespace

void describe(Fields& f, ContactSettings& s) {
  using Limits = ContactSettings::Limits;
  f.field(Limits::enter_distance, s.enter_distance,
          "Distance to the estimated surface below which contact can begin without a measured "
          "wrench.");
  f.constant(Limits::search_distance, s.search_distance);
  f.field(Limits::leave_distance, s.leave_distance,
          "Distance to the estimated surface above which contact is lost.");
  f.field(Limits::touch_force, s.touch_force, "Measured normal force above which the pen touches.");
  f.field(Limits::touch_gap, s.touch_gap,
          "Lag of the tip behind the approach above which the pen touches, without a measured "
          "wrench.");
  f.constant(Limits::loss_force, s.loss_force);
  f.constant(Limits::loss_time, s.loss_time);
  f.field(Limits::lost_surface_time, s.lost_surface_time,
          "Time for which the last normal is trusted when perception has no surface.");
}

void describe(Fields& f, GivenObserver& s) {
  using Limits = GivenObserver::Limits;
  f.field("enabled", s.enabled, "Uses the observer. It needs a measured wrench.");
  f.field(Limits::bandwidth, s.bandwidth,
          "Bandwidth of the observer's low-pass filter. null: 200 rad/s, but 600 rad/s for a "
          "simulated arm whose description has dry friction.");
  f.field(Limits::limit, s.limit, "Largest torque that the observer compensates on a joint.");
  f.field(
      Limits::yield_limit, s.yield_limit,
      "Torque of each joint above which, and above 12 % of its weight torque on top, the observer "
      "compensates only what would move the tip, so that the arm yields to a push on its body; "
      "empty: 0.5 % of the joint's torque limit, at least 1.5 Nm.");
}

void describe(Fields& f, GivenFeltNormal& s) {
  using Limits = GivenFeltNormal::Limits;
  f.field(
      Limits::share, s.share,
      "Of the felt normal, beyond the deviation, in the normal that the law follows. 0: the "
      "force tells nothing of the surface. null: 0, but 0.5 where the surface under the drawing "
      "is rough.");
  f.field(Limits::deviation, s.deviation,
          "Tangent of the angle between felt and perceived normal below which the perceived one is "
          "believed.");
  f.field(Limits::force_error, s.force_error, "Error of the measured force across the normal.");
}

void describe(Fields& f, ForceIntegralSettings& s) {
  using Limits = ForceIntegralSettings::Limits;
  f.field("enabled", s.enabled, "Uses the integral. It needs a measured wrench.");
  f.field(Limits::rate, s.rate, "Integral gain.");
  f.field(Limits::limit, s.limit, "Largest force that the integral adds to the normal force.");
}

void describe(Fields& f, Tool& s) {
  using Limits = Tool::Limits;
  f.field(Limits::mass, s.mass, "Mass of the tool. ./impedraw calibrate-tool identifies it.");
  f.field(Limits::centre, s.p_SC, "Centre of mass in the sensor's frame.");
}

// Ranges at the step of a scenario's world; the estimator's own limits follow from its step.
void describe(Fields& f, SensingSettings& s) {
  f.field("tool", s.tool, "Model of the tool below the sensor.");
  f.field("remove_weight", s.removal.weight, "Removes the tool's weight from the reading.");
  f.field("remove_inertia", s.removal.inertia,
          "Removes the wrench that accelerates the tool from the reading.");
  f.field("remove_coriolis", s.removal.coriolis,
          "Removes the tool's centrifugal and gyroscopic wrench from the reading.");
  f.field("tip_distance", s.tip_distance, {0.0, 2.0}, "m",
          "Modelled distance of the tip from the sensor, along the pen.");
  f.field("sensor_delay", s.sensor_delay, {0.0, 0.03}, "s",
          "Modelled delay of the sensor; null: its true delay.");
  f.field("filter_bandwidth", s.filter_bandwidth, {0.0, 1900.0}, "rad/s",
          "Bandwidth of the wrench's low-pass filter; 0: no filter.");
  f.field("tare_time", s.tare_time, {0.01, 60.0}, "s",
          "Time at rest in the air, before the first stroke, over which the sensor is tared.");
}

void describe(Fields& f, JointSensingSettings& s) {
  using Limits = JointSensingSettings::Limits;
  f.choice("velocity", s.velocity, {"measured", "estimated"},
           "Joint velocities of the control law: as measured, or estimated from the positions, the "
           "torques and the arm's model.");
  f.field(Limits::bandwidth, s.bandwidth, "Bandwidth of the estimator.");
  f.field(
      Limits::least_bandwidth, s.least_bandwidth,
      "Noise of the positions, as measured, lowers the bandwidth to this at the most, or as far "
      "as the stability checks allow.");
  f.field(Limits::sensor_delay, s.sensor_delay,
          "Modelled delay of the joints' sensors; null: their true delay.");
}

void describe(Fields& f, ControlSettings& s) {
  using Limits = ControlSettings::Limits;
  f.choice("inertia", s.inertia, {"natural", "scaled", "shaped"},
           "Desired inertia M_d: the arm's own, a multiple of it, or the constant one set below.");
  f.choice("wrench", s.source, {"none", "ground_truth", "sensor", "realistic"},
           "Source of the external wrench F_ext: none, the simulator, a sensor with the faults in "
           "wrench_sensor, or one with the faults of a real sensor.")
      .formerly("true", "ground_truth");
  f.choice("projection", s.surface.projection, {"lifted", "paper"},
           "Projection of the position error in contact, equation (13): with full stiffness on any "
           "slope, or as in the paper.");
  describe_axial(f, Limits::stiffness, s.stiffness.linear, "Stiffness K along");
  describe_axial(f, Limits::rotational_stiffness, s.stiffness.angular, "Stiffness K about");
  describe_axial(f, Limits::reference_stiffness, s.reference_stiffness.linear,
                 "Stiffness K' that sets the damping where K is zero, along");
  describe_axial(f, Limits::reference_rotational_stiffness, s.reference_stiffness.angular,
                 "Stiffness K' that sets the damping where K is zero, about");
  f.field("mass_tangent", s.shaped_inertia.linear.tangent, Limits::mass.range,
          std::string(Limits::mass.unit),
          "Desired mass for inertia: shaped, along both tangents of the surface.");
  f.field(
      "mass_normal", s.mass_normal, Limits::mass.range, std::string(Limits::mass.unit),
      "Desired mass for inertia: shaped, along the surface normal. A lighter pen follows a rough "
      "surface with a steadier force. null: 1.5 kg, with perception.frames 0.6 kg, or 1.3 times "
      "the "
      "lightest that is stable with a wrench as late as control.sensing makes it.");
  describe_axial(f, Limits::rotational_inertia, s.shaped_inertia.angular,
                 "Desired moment of inertia for inertia: shaped, about");
  f.field(Limits::inertia_scale, s.inertia_scale,
          "Desired inertia as a multiple of the arm's own, for inertia: scaled.");
  f.field(Limits::damping_ratio, s.damping_ratio, "Damping ratio of every mode.");
  f.field(Limits::normal_force, s.normal_force,
          "Normal force that the pen presses with while drawing.")
      .for_users()
      .formerly("push");
  f.field(Limits::switch_time, s.switch_time,
          "Time constant of the transition between contact modes.");
  f.field(Limits::approach_speed, s.approach.speed,
          "Speed along the normal until the pen touches.");
  f.constant(Limits::approach_overtravel, s.approach.overtravel);
  f.field(Limits::approach_lag, s.approach.lag, "Lag of the tip above which the approach waits.");
  f.field(Limits::retreat_height, s.approach.retreat_height,
          "Height above the plan to which the pen retreats when the surface is lost.");
  f.field(Limits::normal_bandwidth, s.surface.normal_bandwidth,
          "Bandwidth of the filter of the surface normal.");
  f.choice(
      "pen_axis", s.pen_axis, {"surface", "plan"},
      "Pen's axis while drawing: along the plan's smoothed normals, or along the estimated normal "
      "at the tip. null: surface, but plan where the surface under the drawing is rough. The pen "
      "pushes along the estimated normal either way.");
  f.field(Limits::tip_radius, s.tip.radius, "Modelled radius of the tip.");
  f.field(Limits::tip_stiffness, s.tip.stiffness,
          "Modelled stiffness of the tip along the normal; 0: rigid.");
  f.field(Limits::friction, s.friction.coefficient,
          "Modelled coefficient of friction: the part of a measured wrench that tip friction can "
          "explain.");
  f.field(
      Limits::normal_error, s.normal_error_deg,
      "The estimated normal may err by this angle. The part of a measured wrench that the error "
      "explains, up to its tangent times the normal force, does not push the pen aside. null: 0, "
      "but 30 where the surface under the drawing is rough.");
  f.field(Limits::friction_feedforward, s.friction.feedforward,
          "Modelled coefficient of friction that is compensated along a stroke without a measured "
          "wrench.");
  f.field(Limits::contact_stiffness_max, s.stability_check.contact_stiffness_max,
          "Stiffest contact of tip and canvas in the stability check at set-up.");
  f.field(Limits::natural_mass_max, s.stability_check.natural_mass_max,
          "Largest effective mass along the normal in the stability check at set-up.");
  f.field(Limits::null_stiffness, s.null_stiffness,
          "Stiffness K_q of the null space, equation (15), one per joint; empty: 10 each.");
  f.field(Limits::null_damping_ratio, s.null_space.damping_ratio,
          "Damping ratio of the null space.");
  f.field("observer", s.observer, "Momentum observer of the torque that the arm's model misses.");
  f.field(
      "torque_delay", s.torque_delay, {0.0, 0.02}, "s",
      "Delay of the drives; loop_delay is then at least one step longer. null: loop_delay alone "
      "counts.");
  f.field(Limits::loop_delay, s.timing.loop_delay,
          "Greatest age of the state while a torque acts: one step and the delay of the drives.");
  f.field("felt_normal", s.felt_normal,
          "The surface's normal as the measured force tells it, where perception smooths it.");
  f.field("force_integral", s.force_integral, "Integral of the force error along the normal.");
  f.field("sensing", s.sensing, "From the sensor's readings to the wrench at the tip.");
  f.field("joint_sensing", s.joint_sensing,
          "From the joints' readings to their positions and velocities.");
  f.field("torque_share", s.torque_share, {0.01, 1.0}, "",
          "Fraction of the arm's torque limits that may be used.");
  f.field(Limits::torque_rate, s.torque_rate, "Largest rate of change of a joint's torque.");
  f.field(
      "joint_speed_share", s.joint_speed_share, {0.01, 1.0}, "",
      "Fraction of the arm's joint speed limits that the control law may ask for; faster joints "
      "are damped.");
  f.field("check_rotors", s.check_rotors,
          "Refuses a simulated arm whose rotors differ from arm.rotor_inertia by more than the law "
          "bears.");
  f.field(Limits::limit_margin, s.joint_range.margin,
          "Distance from its limit at which a joint is pushed back, in the null space.");
  f.constant(Limits::limit_torque, s.joint_range.torque);
  f.field(Limits::tip_speed_limit, s.limits.tip_speed,
          "Largest tip speed that the control law may ask for.");
  f.field(Limits::turn_speed_limit, s.limits.turn_speed,
          "Largest angular speed of the pen's axis that the control law may ask for.");
  f.field(Limits::max_state_age, s.timing.max_state_age, "Age above which a joint state is stale.");
  f.field(Limits::max_wrench_age, s.timing.max_wrench_age, "Age above which a wrench is stale.");
  f.field("contact", s.contact, "When contact begins and ends.");
}

}  // namespace impedraw
