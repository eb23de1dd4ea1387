// The settings of a scenario under `world`, `wrench_sensor`, `pushes` and `faults`.
#include "impedraw/experiment/scenario.h"

namespace impedraw {

void describe(Fields& f, TipMaterial& s) {
  using Limits = TipMaterial::Limits;
  f.field(Limits::radius, s.radius, "Radius of the tip sphere.");
  f.field(Limits::stiffness, s.stiffness, "Stiffness along the normal.");
  f.field(Limits::damping, s.damping, "Damping along the normal.");
  f.field(Limits::friction, s.friction, "Coulomb friction coefficient of tip and canvas.");
  f.field(Limits::friction_change, s.friction_change,
          "Share of the friction coefficient that varies along the line.");
  f.field(Limits::friction_length, s.friction_length, "Wavelength of that along the line.");
  f.field(Limits::wear, s.wear,
          "Length that wears off the tip for each N along the normal and metre slid.");
}

void describe(Fields& f, ModelErrors& s) {
  using Limits = ModelErrors::Limits;
  f.field(Limits::mass_scale, s.mass_scale,
          "True mass and inertia of every link and the pen as a multiple of the modelled ones.");
  f.field(Limits::centre_shift, s.centre_shift, "Shift of every link's centre of mass.");
  f.field(Limits::viscous_friction, s.viscous_friction, "Viscous friction of every joint.");
  f.field(Limits::rotor_inertia, s.rotor_inertia,
          "True rotor inertia: one for all joints or one for each; empty: as arm.rotor_inertia.")
      .or_one();
  f.field(Limits::stiction, s.stiction,
          "Dry friction of a joint at rest, as a multiple of that in motion.");
  f.field(Limits::stribeck_speed, s.stribeck_speed, "Joint speed up to which stiction reaches.");
  f.field(Limits::load_friction, s.load_friction,
          "Dry friction of a joint for each Nm that its gear carries.");
  f.field(Limits::friction_ripple, s.friction_ripple,
          "Share of a joint's dry friction that varies with its position.");
  f.field(Limits::torque_ripple, s.torque_ripple, "Amplitude of the torque ripple of every joint.");
  f.field(Limits::torque_quantum, s.torque_quantum,
          "Resolution of the joint torques; 0: continuous.");
  f.field(Limits::loop_delay, s.loop_delay, "Delay after which a commanded torque acts.");
  f.field(Limits::pen_longer, s.pen_longer, "Length of the true pen beyond the modelled one.");
  f.field(Limits::pens_longer, s.pens_longer,
          "The same of each of pens, in order, beyond its `longer`; beyond the list's end "
          "pen_longer.");
}

void describe(Fields& f, WrenchSensorSettings& s) {
  using Limits = WrenchSensorSettings::Limits;
  f.field(Limits::noise_force, s.noise_force, "Standard deviation of a force sample at 1 kHz.");
  f.field(Limits::noise_torque, s.noise_torque, "Standard deviation of a torque sample at 1 kHz.");
  f.field(Limits::bias_force, s.bias_force,
          "Magnitude of the force bias. Its direction comes from the seed.");
  f.field(Limits::bias_torque, s.bias_torque,
          "Magnitude of the torque bias. Its direction comes from the seed.");
  f.field(Limits::drift_force, s.drift_force, "Drift of the force bias.");
  f.field(Limits::drift_torque, s.drift_torque, "Drift of the torque bias.");
  f.field(Limits::quantum_force, s.quantum_force, "Resolution of the force; 0: continuous.");
  f.field(Limits::quantum_torque, s.quantum_torque, "Resolution of the torque; 0: continuous.");
  f.field(Limits::range_force, s.range_force, "Force at which an axis saturates; 0: never.");
  f.field(Limits::range_torque, s.range_torque, "Torque at which an axis saturates; 0: never.");
  f.field(Limits::gain_error, s.gain_error,
          "Error of each axis's gain, up or down as the seed says.");
  f.field(Limits::cross_talk, s.cross_talk,
          "Share of the other axes in each reading; 10 N count as 1 Nm.");
  f.field(Limits::delay, s.delay, "Delay of the readings.");
}

void describe(Fields& f, JointSpringSettings& s) {
  using Limits = JointSpringSettings::Limits;
  f.choice("arm", s.arm, {"none", "iiwa", "fr3", "harmonic_drive"},
           "Published values of an arm; none: rigid joints, unless stiffness is given.");
  f.field(Limits::stiffness, s.stiffness,
          "Between each rotor and its link: one for all joints or one for each; empty: as "
          "published.")
      .or_one();
  f.field(Limits::damping, s.damping, "Beside the spring; empty: 1 ms times the stiffness.")
      .or_one();
  f.field(Limits::rotor_inertia, s.rotor_inertia,
          "Inertia of the rotors over their gears; empty: as published.")
      .or_one();
  f.field(Limits::loop_bandwidth, s.loop_bandwidth,
          "Bandwidth of the arm's own torque loop; 0: none; null: as published.");
  f.field(Limits::sensor_ripple, s.sensor_ripple, "Ripple of the joints' torque sensors.");
  f.field(Limits::sensor_offset, s.sensor_offset,
          "Offset of the joints' torque sensors, up and down in turn.");
  f.choice("reading", s.reading, {"as_published", "motor", "link"},
           "Side of the spring whose position the joints' sensors read.");
}

void describe(Fields& f, JointSensorSettings& s) {
  using Limits = JointSensorSettings::Limits;
  f.field(Limits::quantum, s.quantum, "Resolution of the joint positions; 0: continuous.");
  f.field(Limits::position_noise, s.position_noise,
          "Standard deviation of the white noise of a position sample.");
  f.field(Limits::velocity_noise, s.velocity_noise,
          "Standard deviation of the white noise of a velocity sample.");
  f.field(Limits::delay, s.delay, "Delay of the readings.");
  f.choice("velocity", s.velocity, {"exact", "difference", "none"},
           "Velocities that the sensors give: the true ones, the filtered difference of the "
           "positions, or none; none needs control.joint_sensing.velocity: estimated.");
  f.field(Limits::velocity_bandwidth, s.velocity_bandwidth,
          "Bandwidth of the low-pass filter of the difference; 0: no filter.");
}

void describe(Fields& f, WorldSettings& s) {
  using Limits = WorldSettings::Limits;
  f.field("errors", s.errors, "Differences between the true arm and its model.");
  f.field("tip", s.tip, "True properties of the pen's tip.");
  f.field(Limits::joint_friction, s.joint_friction, "Coulomb friction of every joint.");
  f.field(Limits::gravity, s.gravity, "Gravity along -z.");
  f.field("joint_spring", s.joint_spring, "Springs between the joints' rotors and links.");
  f.field("joint_sensor", s.joint_sensor, "Faults of the joints' sensors.");
  f.field(Limits::substeps, s.substeps,
          "Integration steps in each control step; the torque is held.");
}

void describe(Fields& f, PushSettings& s) {
  f.field("force", s.force, {0.0, 200.0}, "N",
          "Force: tangential on the pen tip, or as it is on a link.");
  f.field("link", s.link,
          "Link of the arm that is pushed at its origin, such as link_4, the elbow; empty: the "
          "pen.");
  f.field("direction", s.direction_W, {-1.0, 1.0}, "",
          "Direction of the force in world axes; on the pen it is projected onto the canvas's "
          "tangent plane.");
  f.field("lift", s.lift, {-200.0, 200.0}, "N",
          "Additional force on the pen along the canvas's outward normal.");
  f.field("middle", s.middle, {0.0, 1.0}, "",
          "Middle of the push, as a fraction of the time from the start of the first stroke to the "
          "end of the last.");
  f.field("duration", s.duration, {0.0, 1000.0}, "s", "Duration of the push.");
}

void describe(Fields& f, FaultSettings& s) {
  f.choice("kind", s.kind,
           {"nan_state", "stale_state", "nan_wrench", "stale_wrench", "no_cloud", "no_frames",
            "slow_step", "jumped_state", "drifting_state", "standing_state", "false_speed",
            "false_wrench", "future_wrench"},
           "Fault around the controller.");
  f.field("start", s.start, {0.0, 1.0}, "",
          "Start of the fault, as a fraction of the time from the start of the first stroke to the "
          "end of the last.")
      .formerly("middle");
  f.field("duration", s.duration, {0.0, 1000.0}, "s", "Duration of the fault.");
}

}  // namespace impedraw
