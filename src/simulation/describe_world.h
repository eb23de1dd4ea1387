// Description of the simulated world's settings (world_settings.h).
// See control/describe_control.h.
#pragma once

#include "impedraw/common/range.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

inline constexpr Range kSpringStiffnessRange{100.0, 1e6};  // [Nm/rad]
inline constexpr Range kSpringRotorRange{1e-4, 10.0};      // [kg m²]
inline constexpr Range kTorqueLoopRange{0.0, 1e4};         // [rad/s]
inline constexpr Range kPenLongerRange{-0.02, 0.02};       // of a tip, than in arm.urdf [m]
inline constexpr Range kPadRadiusRange{5e-5, 0.1};         // [m]
inline constexpr Range kFoamStiffnessRange{1e4, 1e9};      // [N/m³]

template <class F>
void describe(F& f, TipMaterial& s) {
  f.field("radius", s.radius, {1e-5, 0.05}, "m", "Radius of the tip sphere.");
  f.field("stiffness", s.stiffness, {10.0, 1e7}, "N/m", "Stiffness along the normal.");
  f.constant("damping", s.damping, {0.0, 1e5}, "N s/m");
  f.field("friction", s.friction, {0.0, 3.0}, "",
          "Coulomb friction coefficient of tip and canvas.");
  f.field("friction_change", s.friction_change, {0.0, 1.0}, "",
          "Share of the friction coefficient that varies along the line.");
  f.field("friction_length", s.friction_length, {1e-3, 10.0}, "m",
          "Wavelength of that along the line.");
  f.field("wear", s.wear, {0.0, 0.01}, "m/(N m)",
          "Length that wears off the tip for each N along the normal and metre slid.");
}

template <class F>
void describe(F& f, ModelErrors& s) {
  f.field("mass_scale", s.mass_scale, {0.1, 10.0}, "",
          "True mass and inertia of every link and the pen as a multiple of the modelled ones.");
  f.field("centre_shift", s.centre_shift, {-0.2, 0.2}, "m",
          "Shift of every link's centre of mass.");
  f.field("viscous_friction", s.viscous_friction, {0.0, 100.0}, "Nm s/rad",
          "Viscous friction of every joint.");
  f.field("rotor_inertia", s.rotor_inertia, {0.0, 10.0}, "kg m²",
          "True rotor inertia: one for all joints or one for each; empty: as arm.rotor_inertia.")
      .or_one();
  f.field("stiction", s.stiction, {1.0, 10.0}, "",
          "Dry friction of a joint at rest, as a multiple of that in motion.");
  f.field("stribeck_speed", s.stribeck_speed, {1e-4, 10.0}, "rad/s",
          "Joint speed up to which stiction reaches.");
  f.field("load_friction", s.load_friction, {0.0, 1.0}, "",
          "Dry friction of a joint for each Nm that its gear carries.");
  f.field("friction_ripple", s.friction_ripple, {0.0, 1.0}, "",
          "Share of a joint's dry friction that varies with its position.");
  f.field("torque_ripple", s.torque_ripple, {0.0, 20.0}, "Nm",
          "Amplitude of the torque ripple of every joint.");
  f.field("torque_quantum", s.torque_quantum, {0.0, 10.0}, "Nm",
          "Resolution of the joint torques; 0: continuous.");
  f.field("loop_delay", s.loop_delay, {0.0, 0.015}, "s",
          "Delay after which a commanded torque acts.");
  f.field("pen_longer", s.pen_longer, kPenLongerRange, "m",
          "Length of the true pen beyond the modelled one.");
  f.field("pens_longer", s.pens_longer, kPenLongerRange, "m",
          "The same of each of pens, in order, beyond its `longer`; beyond the list's end "
          "pen_longer.");
}

template <class F>
void describe(F& f, WrenchSensorSettings& s) {
  f.field("noise_force", s.noise_force, {0.0, 100.0}, "N",
          "Standard deviation of a force sample at 1 kHz.");
  f.field("noise_torque", s.noise_torque, {0.0, 10.0}, "Nm",
          "Standard deviation of a torque sample at 1 kHz.");
  f.field("bias_force", s.bias_force, {0.0, 1000.0}, "N",
          "Magnitude of the force bias. Its direction comes from the seed.");
  f.field("bias_torque", s.bias_torque, {0.0, 100.0}, "Nm",
          "Magnitude of the torque bias. Its direction comes from the seed.");
  f.field("drift_force", s.drift_force, {0.0, 100.0}, "N/min", "Drift of the force bias.");
  f.field("drift_torque", s.drift_torque, {0.0, 10.0}, "Nm/min", "Drift of the torque bias.");
  f.field("quantum_force", s.quantum_force, {0.0, 10.0}, "N",
          "Resolution of the force; 0: continuous.");
  f.field("quantum_torque", s.quantum_torque, {0.0, 1.0}, "Nm",
          "Resolution of the torque; 0: continuous.");
  f.field("range_force", s.range_force, {0.0, 1e5}, "N",
          "Force at which an axis saturates; 0: never.");
  f.field("range_torque", s.range_torque, {0.0, 1e4}, "Nm",
          "Torque at which an axis saturates; 0: never.");
  f.field("gain_error", s.gain_error, {0.0, 0.5}, "",
          "Error of each axis's gain, up or down as the seed says.");
  f.field("cross_talk", s.cross_talk, {0.0, 0.5}, "",
          "Share of the other axes in each reading; 10 N count as 1 Nm.");
  f.field("delay", s.delay, {0.0, 0.03}, "s", "Delay of the readings.");
}

template <class F>
void describe(F& f, JointSpringSettings& s) {
  f.choice("arm", s.arm, {"none", "iiwa", "fr3", "harmonic_drive"},
           "Published values of an arm; none: rigid joints, unless stiffness is given.");
  f.field("stiffness", s.stiffness, kSpringStiffnessRange, "Nm/rad",
          "Between each rotor and its link: one for all joints or one for each; empty: as "
          "published.")
      .or_one();
  f.field("damping", s.damping, {0.0, 1000.0}, "Nm s/rad",
          "Beside the spring; empty: 1 ms times the stiffness.")
      .or_one();
  f.field("rotor_inertia", s.rotor_inertia, kSpringRotorRange, "kg m²",
          "Inertia of the rotors over their gears; empty: as published.")
      .or_one();
  f.field("loop_bandwidth", s.loop_bandwidth, kTorqueLoopRange, "rad/s",
          "Bandwidth of the arm's own torque loop; 0: none; null: as published.");
  f.field("sensor_ripple", s.sensor_ripple, {0.0, 20.0}, "Nm",
          "Ripple of the joints' torque sensors.");
  f.field("sensor_offset", s.sensor_offset, {0.0, 20.0}, "Nm",
          "Offset of the joints' torque sensors, up and down in turn.");
  f.choice("reading", s.reading, {"as_published", "motor", "link"},
           "Side of the spring whose position the joints' sensors read.");
}

template <class F>
void describe(F& f, JointSensorSettings& s) {
  f.field("quantum", s.quantum, {0.0, 0.1}, "rad",
          "Resolution of the joint positions; 0: continuous.");
  f.field("position_noise", s.position_noise, {0.0, 0.1}, "rad",
          "Standard deviation of the white noise of a position sample.");
  f.field("velocity_noise", s.velocity_noise, {0.0, 10.0}, "rad/s",
          "Standard deviation of the white noise of a velocity sample.");
  f.field("delay", s.delay, {0.0, 0.03}, "s", "Delay of the readings.");
  f.choice("velocity", s.velocity, {"exact", "difference", "none"},
           "Velocities that the sensors give: the true ones, the difference of the "
           "positions through a low-pass of 250 rad/s, or none; none needs "
           "control.joint_sensing.velocity: estimated.");
  f.constant("velocity_bandwidth", s.velocity_bandwidth, {0.0, 1e4}, "rad/s");
}

template <class F>
void describe(F& f, CanvasMotionSettings& s) {
  f.field("centre", s.centre, {-10.0, 10.0}, "m", "Point that the canvas turns and rolls about.");
  f.field("start", s.start, {-1e4, 1e4}, "s", "Time at which it starts to move.");
  f.field("stop", s.stop, {-1e4, 1e6}, "s",
          "Time at which it starts to stop; null: it never stops.");
  f.field("ramp", s.ramp, {0.01, 60.0}, "s",
          "Time that it takes to reach its full motion, and to stop.");
  f.field("velocity", s.velocity, {-2.0, 2.0}, "m/s", "Constant velocity, as on a conveyor.");
  f.field("turn_axis", s.turn_axis, {-1.0, 1.0}, "", "Axis of a turntable.");
  f.field("turn_speed", s.turn_speed, {-10.0, 10.0}, "rad/s", "Angular speed of the turntable.");
  f.field("sway", s.sway, {-1.0, 1.0}, "m",
          "Amplitude of a sinusoidal translation, heave or sway.");
  f.field("sway_frequency", s.sway_frequency, {0.0, 20.0}, "Hz", "Its frequency.");
  f.field("roll_axis", s.roll_axis, {-1.0, 1.0}, "", "Axis of a sinusoidal rotation.");
  f.field("roll", s.roll, {-1.0, 1.0}, "rad", "Its amplitude.");
  f.field("roll_frequency", s.roll_frequency, {0.0, 20.0}, "Hz", "Its frequency.");
  f.field("jolts", s.jolts, {0.0, 0.1}, "m",
          "Root-mean-square displacement by random jolts, on each axis, of up to 1 Hz.");
  f.constant("jolt_bandwidth", s.jolt_bandwidth, {0.01, 20.0}, "Hz");
  f.field("file", s.file,
          "A recorded motion in place of all of these, CSV: t [s], x, y, z [m], qw, qx, qy, qz of "
          "any frame fixed to the canvas, at least every 0.25 s.");
}

template <class F>
void describe(F& f, WorldSettings& s) {
  f.field("errors", s.errors, "Differences between the true arm and its model.");
  f.field("tip", s.tip, "True properties of the pen's tip.");
  f.field("joint_friction", s.joint_friction, {0.0, 50.0}, "Nm",
          "Coulomb friction of every joint.");
  f.field("gravity", s.gravity, {0.0, 100.0}, "m/s²", "Gravity along -z.");
  f.field("joint_spring", s.joint_spring, "Springs between the joints' rotors and links.");
  f.field("joint_sensor", s.joint_sensor, "Faults of the joints' sensors.");
  f.constant("substeps", s.substeps, {1, 100}, "");
}

}  // namespace impedraw
