// The settings of a scenario under `control`.
#include "impedraw/control/describe_control.h"
#include "impedraw/experiment/scenario.h"

namespace impedraw {

void describe(Fields& f, Tool& s) {
  f.field(Tool::Limits::mass, s.mass, "Mass of the tool. ./impedraw calibrate-tool identifies it.");
  f.field(Tool::Limits::centre, s.p_SC, "Centre of mass in the sensor's frame.");
}

// Ranges at the step of a scenario's world; the estimator's own limits follow from its step.
void describe(Fields& f, SensingSettings& s) {
  f.field("tool", s.tool, "Model of the tool below the sensor.");
  f.constant("remove_weight", true);
  f.constant("remove_inertia", true);
  f.constant("remove_coriolis", true);
  f.constant("tip_distance", s.tip_distance, Range::any(), "m");
  f.field("sensor_delay", s.sensor_delay, {0.0, 0.03}, "s",
          "Modelled delay of the sensor; null: its true delay.");
  f.constant("filter_bandwidth", 0.0, Range::any(), "rad/s");
  f.constant("tare_time", s.tare_time, Range::any(), "s");
}

void describe(Fields& f, JointSensingSettings& s) {
  using Limits = JointStateEstimatorSettings::Limits;
  f.choice("velocity", s.velocity, {"measured", "estimated"},
           "Joint velocities of the control law: as measured, or estimated from the positions, the "
           "torques and the arm's model.");
  f.field(Limits::bandwidth, s.bandwidth,
          "Bandwidth of the estimator. Noise of the positions, as measured, lowers it to 150 rad/s "
          "at the most, or as far as the stability checks allow.");
  f.constant("least_bandwidth", s.least_bandwidth, Range::any(), "rad/s");
  f.field(Limits::sensor_delay, s.sensor_delay,
          "Modelled delay of the joints' sensors; null: their true delay.");
}

void describe(Fields& f, GivenFeltNormal& s) { describe_felt_normal(f, s); }
void describe(Fields& f, GivenObserver& s) { describe_observer(f, s, s.bandwidth); }

void describe(Fields& f, ControlSettings& s) {
  describe(f, static_cast<ImpedanceSettings&>(s));
  f.choice("wrench", s.source, {"none", "ground_truth", "sensor", "realistic"},
           "Source of the external wrench F_ext: none, the simulator, a sensor with the faults in "
           "wrench_sensor, or one with the faults of a real sensor.")
      .formerly("true", "ground_truth");
  f.field(
      "mass_normal", s.mass_normal, kMassRange, "kg",
      "Desired mass for inertia: shaped, along the surface normal. A lighter pen follows a rough "
      "surface with a steadier force. null: 1.5 kg, with perception.frames 0.6 kg, or 1.3 times "
      "the "
      "lightest that is stable with a wrench as late as control.sensing makes it.");
  f.choice(
      "pen_axis", s.pen_axis, {"surface", "plan"},
      "Pen's axis while drawing: along the plan's smoothed normals, or along the estimated normal "
      "at the tip. null: surface, but plan under a pad, and where the surface under the drawing "
      "is rough. The pen pushes along the estimated normal either way.");
  f.field(
      "normal_error", s.normal_error_deg, kNormalErrorRange, "deg",
      "The estimated normal may err by this angle. The part of a measured wrench that the error "
      "explains, up to its tangent times the normal force, does not push the pen aside. null: 0, "
      "but 30 under a pad, and where the surface under the drawing is rough.");
  f.field("null_stiffness", s.null_stiffness, kNullStiffnessRange, "Nm/rad",
          "Stiffness K_q of the null space, equation (15), one per joint; empty: 10 each.");
  f.field(
      "torque_delay", s.torque_delay, {0.0, 0.02}, "s",
      "Delay of the drives; loop_delay is then at least one step longer. null: loop_delay alone "
      "counts.");
  f.field("felt_normal", s.felt_normal,
          "The surface's normal as the measured force tells it, where perception smooths it.");
  f.field("observer", s.observer, "Momentum observer of the torque that the arm's model misses.");
  f.field("sensing", s.sensing, "From the sensor's readings to the wrench at the tip.");
  f.field("joint_sensing", s.joint_sensing,
          "From the joints' readings to their positions and velocities.");
  f.field("torque_share", s.torque_share, {0.01, 1.0}, "",
          "Fraction of the arm's torque limits that may be used.");
  f.field("torque_rate", s.torque_rate, kTorqueRateRange, "Nm/s",
          "Largest rate of change of a joint's torque.");
  f.field(
      "joint_speed_share", s.joint_speed_share, {0.01, 1.0}, "",
      "Fraction of the arm's joint speed limits that the control law may ask for; faster joints "
      "are damped.");
  f.field("check_rotors", s.check_rotors,
          "Refuses a simulated arm whose rotors differ from arm.rotor_inertia by more than the law "
          "bears.");
}

}  // namespace impedraw
