// Settings of the simulated world, apart from what simulates: a scenario has them, and its reader
// need not link the simulator. Each is explained where it is used: tip_contact.h, pad_contact.h,
// cut_forces.h, joint_sensor.h, joint_springs.h, wrench_sensor.h, canvas_motion.h, world.h.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "impedraw/simulation/cut_forces.h"

namespace impedraw {

struct TipMaterial {
  double radius = 1.0e-3;     // of the tip sphere [m]
  double stiffness = 20.0e3;  // k [N/m]
  double damping = 60.0;      // b [N s/m]
  double friction = 0.3;      // μ
  // Along the line (tip_line.h)
  double friction_change = 0.0;   // a, a share of μ
  double friction_length = 0.02;  // L [m]
  double wear = 0.0;              // k, length per work of a tangential force f_n [m/(N m)]
};

// The shape of a face that touches instead of the ball's point (pad_contact.h).
enum class PadFace {
  disc,  // a pad
  edge,  // a line along x_E: a blade
  axle,  // a line along y_E: a roller
};

struct PadSettings {
  double radius = 0.015;     // r; of a line: half its length [m]
  double thickness = 0.010;  // of the foam, or of what gives way beneath a line [m]
  double stiffness = 2e6;    // k, pressure per compression [N/m³]; of a line [N/m²]
  double damping = 8e3;      // b [N s/m³]; of a line [N s/m²]
  double friction = 0.3;     // μ; of a line: against motion along x_E
  double rest = 0.0;         // of the free face before E [m]
  PadFace face = PadFace::disc;
  double friction_across = 0.0;  // of a line: against motion along y_E
  double trail = 0.0;            // of a line's middle behind E, along −x_E [m]
  int joints = 0;                // of a disc: 1: about x_E, 2: about y_E, too
  double pivot = 0.0;            // of the joints' centre behind the rigid disc [m]

  double area() const;  // π r² [m²]; of a line: its length [m]
  // From the joints' centre to the surface, with the foam pressed as far as its face lies before E.
  double lever() const { return thickness - rest + pivot; }  // [m]
  // Pressure of the foam, compressed by δ at the rate v [Pa]; of a line [N/m].
  double pressure(double compression, double rate) const {
    return compression > 0.0 ? std::max(0.0, stiffness * compression + damping * rate) : 0.0;
  }
};

enum class VelocityReading { exact, difference, none };

struct JointSensorSettings {
  double quantum = 0.0;         // resolution of the position; 0: continuous [rad]
  double position_noise = 0.0;  // standard deviation [rad]
  double velocity_noise = 0.0;  // standard deviation [rad/s]
  double delay = 0.0;  // rounded to samples, at most 30 ms; the first is read without delay [s]
  VelocityReading velocity = VelocityReading::exact;
  double velocity_bandwidth = 250.0;  // of the difference's low-pass; 0: no filter [rad/s]

  bool exact() const {  // reads the state itself
    return quantum == 0.0 && position_noise == 0.0 && velocity_noise == 0.0 && delay == 0.0 &&
           velocity == VelocityReading::exact;
  }
  // Age of the velocity reading at low frequency, for samples dt apart [s].
  double velocity_age(double dt) const;
};

struct WrenchSensorSettings {
  // white noise on each axis: standard deviation at 1 kHz; same density at other rates [N, Nm]
  double noise_force = 0.0, noise_torque = 0.0;
  double bias_force = 0.0, bias_torque = 0.0;        // length of the vector [N, Nm]
  double drift_force = 0.0, drift_torque = 0.0;      // length of the vector [N/min, Nm/min]
  double quantum_force = 0.0, quantum_torque = 0.0;  // 0: continuous [N, Nm]
  double range_force = 0.0, range_torque = 0.0;      // ±; 0: no limit [N, Nm]
  double gain_error = 0.0;                           // of each axis, up or down as the seed says
  double cross_talk = 0.0;                           // of the other axes in each
  // rounded to samples; the first sample is read without delay [s]
  double delay = 0.0;

  static WrenchSensorSettings realistic();
};

// Throws InputError for a setting out of range. dt: time between samples [s].
void require_valid(const WrenchSensorSettings& settings, double dt);

struct CanvasMotionSettings {
  // c: what the canvas turns and rolls about, W [m]
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();

  // Conveyor and turntable. From `start` to `stop` [s]; each takes `ramp` [s] to reach or to leave
  // full speed, the acceleration is bounded and continuous.
  double start = 0.0, ramp = 0.5;
  std::optional<double> stop;                          // absent: never
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // W [m/s]
  Eigen::Vector3d turn_axis = Eigen::Vector3d::UnitZ();
  double turn_speed = 0.0;  // about turn_axis through the centre [rad/s]

  // Heave and sway: amplitude · sin(2π frequency (t − start)), its amplitude grows over `ramp`.
  Eigen::Vector3d sway = Eigen::Vector3d::Zero();  // amplitude, W [m]
  double sway_frequency = 0.5;                     // [Hz]
  Eigen::Vector3d roll_axis = Eigen::Vector3d::UnitX();
  double roll = 0.0;            // amplitude about roll_axis through the centre [rad]
  double roll_frequency = 0.3;  // [Hz]

  // A hand that jolts it: noise along each axis of W, its spectrum flat up to `jolt_bandwidth`.
  double jolts = 0.0;           // RMS [m]
  double jolt_bandwidth = 1.0;  // [Hz]
  std::uint64_t seed = 1;

  // A recorded motion (recorded_motion.h), in place of all of these. Empty: none.
  std::filesystem::path file;
};

// Differences between the simulated arm and the URDF that the controller uses. All are off by
// default. Dry friction is in WorldSettings.
//
// Plant, true        M' v̇ + C' v + g' = τ_a − b v + …
//                    M', C', g' with mass_scale and centre_shift; M' with the true rotor_inertia
//                    on the diagonal
// Torque that acts   τ_a = round(τ(t − loop_delay) / quantum) quantum + A sin(30 q_j + φ_j)
//                    φ_j = 2π · 0.381966 j: a different phase for each joint
struct ModelErrors {
  static constexpr double kRipplePeriods = 30.0;  // per turn of the joint
  static constexpr int kMostDelaySteps = 16;

  double mass_scale = 1.0;  // of mass and inertia of every link, including the pen; > 0
  // shift of the c.o.m. along (1,1,1)/√3 of the link's axes, for every link with its own joint;
  // excludes the pen [m]
  double centre_shift = 0.0;
  double viscous_friction = 0.0;  // b, every joint, ≥ 0 [Nm s/rad]
  // True, about every joint's axis or about each, ≥ 0; empty: what the URDF says (arm_notes.h),
  // else zero [kg m²]
  std::vector<double> rotor_inertia;
  // Dry friction's course (gear_friction.h)
  double stiction = 1.0;         // at rest, a multiple of that in motion
  double stribeck_speed = 0.02;  // to which that reaches [rad/s]
  double load_friction = 0.0;    // more of it for each Nm that the gear carries
  double friction_ripple = 0.0;  // a share of it
  double torque_ripple = 0.0;    // A, every joint [Nm]
  double torque_quantum = 0.0;   // torque resolution, ≥ 0; 0: continuous [Nm]
  // rounded to steps, at most kMostDelaySteps; the first torque acts without delay [s]
  double loop_delay = 0.0;
  // offset of the true tip E along its z from its place in the URDF [m]
  double pen_longer = 0.0;
  // The same of each of `pens`, in order, beyond what they say; beyond its end pen_longer [m]
  std::vector<double> pens_longer;
};

// Whose values stand where none are given: joint_springs.cc has them with their sources.
enum class SpringsOf { none, iiwa, fr3, harmonic_drive };

// The side of the spring that the joints' sensors read.
enum class SpringSide { as_published, motor, link };

struct JointSpringSettings {
  SpringsOf arm = SpringsOf::none;
  // Values of all joints or of each; empty: as published.
  std::vector<double> stiffness;      // K; with neither this nor `arm`, joints are rigid [Nm/rad]
  std::vector<double> damping;        // D; empty: K · 1 ms [Nm s/rad]
  std::vector<double> rotor_inertia;  // B [kg m²]
  std::optional<double> loop_bandwidth;  // ω; 0: u is the motor's torque [rad/s]
  double sensor_ripple = 0.0;            // of s: amplitude [Nm]
  double sensor_offset = 0.0;            // of s, up and down in turn along the arm [Nm]
  SpringSide reading = SpringSide::as_published;

  bool on() const { return arm != SpringsOf::none || !stiffness.empty(); }
};

struct WorldSettings {
  double dt = 1e-3;  // of a control step, over which the torque is held [s]
  int substeps = 1;  // integration steps in each; 4 and 16 move the ink by less than 5 µm
  TipMaterial tip;
  std::optional<PadSettings> pad;        // instead of the tip's ball
  std::optional<CutterSettings> cutter;  // at its lowest point
  double joint_friction = 0.0;           // dry friction, equal on every joint: ± [Nm]
  double gravity = 9.81;                 // along −z [m/s²]
  ModelErrors errors;                    // differences from the URDF
  JointSpringSettings joint_spring;      // replace errors.rotor_inertia
  JointSensorSettings joint_sensor;      // read by the simulated arm
  bool flange_sensor = false;            // enables flange_wrench()
};

// Throws InputError for a setting out of range.
void require_valid(const WorldSettings& settings);

// Numbers of steps since the simulation began.
struct SolverCutoffs {
  long tip = 0;     // sliding tip: kTipContactSweeps (tip_contact.h)
  long joints = 0;  // joint friction, joint limits and tip together: kJointSweeps
};

}  // namespace impedraw
