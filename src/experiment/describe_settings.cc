// The settings of a scenario under `perception` and `control`.
#include "impedraw/control/describe_control.h"
#include "impedraw/experiment/scenario.h"

namespace impedraw {

void describe(Fields& f, CameraSettings& s) {
  using Limits = CameraSettings::Limits;
  f.field("position", s.p_WC, {-10.0, 10.0}, "m", "Position of the pinhole.");
  f.field("target", s.target_W, {-10.0, 10.0}, "m", "Point in the middle of the image.");
  f.field(Limits::width, s.width, "Width of the image.");
  f.field(Limits::height, s.height, "Height of the image.");
  f.field(Limits::fov_y, s.fov_y_deg, "Vertical field of view.");
}

void describe(Fields& f, DepthNoise& s) {
  f.field(DepthNoise::Limits::sigma_at_1m, s.sigma_at_1m,
          "Standard deviation of the depth at 1 m; it grows with depth². A real camera has 0.001.");
  f.constant("quantum_at_1m", 0.0, Range::any(), "m");
}

void describe(Fields& f, CameraErrors& s) {
  f.field("shift", s.shift, {0.0, 0.1}, "m",
          "Distance of each true camera from where it is believed to be. Its direction comes from "
          "the seed.");
  f.field(
      "turn", s.turn_deg, {0.0, 10.0}, "deg",
      "Angle of each true camera to how it is believed to stand. Its axis comes from the seed.");
  f.field("depth_scale", s.depth_scale, {-0.2, 0.2}, "",
          "Relative error of every depth: 0.01 reads 1 % too far.");
  f.field("time_stamp", s.time_stamp, {-0.2, 0.2}, "s",
          "How much later than its exposure a frame's time stamp is.");
}

void describe(Fields& f, NormalSettings& s) {
  f.constant("mode", std::string_view("fresh"));
  f.field("k", s.k, NormalSettings::kNeighbours, "",
          "Number of nearest neighbours, equation (18).");
  f.constant("max_radius", s.max_radius, Range::any(), "m");
  f.choice("weighting", s.weighting, {"uniform", "smooth"},
           "Weights of the neighbours: all equal, as in the paper, or fading out with distance.");
  f.choice("fit", s.fit, {"plane", "quadric"},
           "Surface fitted through the neighbours: a plane, as in the paper, or a quadric.");
  f.constant("max_one_sidedness", s.max_one_sidedness, Range::any(), "");
}

void describe(Fields& f, FrameSettings& s) {
  f.field("enabled", s.enabled, "Cameras keep capturing; off: one snapshot before drawing.");
  f.field("rate", s.rate, {1.0, 200.0}, "Hz", "Frames of each camera in a second.");
  f.field("latency", s.latency, {0.0, 0.5}, "s", "Mean time from a frame's exposure to its use.");
  f.field("latency_jitter", s.latency_jitter, {0.0, 0.1}, "s", "Standard deviation of that time.");
  f.field("drop", s.drop, Range::to_below(0.0, 1.0), "", "Share of the frames that never arrive.");
  f.field(
      "stamp_error", s.stamp_error, {-0.2, 0.2}, "s",
      "Subtracted from a frame's time stamp to have its exposure; ./impedraw arm camera-latency "
      "finds it.");
  f.field("prediction", s.prediction,
          "Predicts the canvas's pose from the last frame to the present; off: to see its worth.");
  f.field("feedforward", s.feedforward,
          "Feeds the canvas's velocity and acceleration forward; off: to see their worth.");
  f.field("wait_for_rest", s.wait_for_rest,
          "For a canvas that is moved by hand between strokes: while it moves, the pen waits above "
          "it and the plan's clock stands.");
  f.field("skew", s.skew, {0.0, 0.1}, "s", "Time from one camera's exposure to the next one's.");
  f.field("depth", s.depth,
          "Frames carry depths, by which the canvas's own shape tells where it is; off: marks "
          "alone do.");
  f.field("depth_every", s.depth_every, {1, 1000}, "", "Every how many-th frame carries depths.");
  f.field("grow_surface", s.grow_surface,
          "Depths improve the surface under the pen; off: it stays as the snapshot saw it.");
  f.constant("region_of_interest", true);
  f.constant("width", s.width, Range::any(), "px");
  f.constant("height", s.height, Range::any(), "px");
}

void describe(Fields& f, Fiducial& s) {
  f.field("position", s.p_K, {-10.0, 10.0}, "m", "Position, while the canvas has not moved.");
}

void describe(Fields& f, FiducialSettings& s) {
  f.field("points", s.points, "Marks on the canvas's frame.");
  f.field(FiducialSettings::Limits::noise, s.noise,
          "Standard deviation of each axis of a mark's position in one frame of one camera.");
}

void describe(Fields& f, PerceptionSettings& s) {
  using Limits = PerceptionSettings::Limits;
  f.field("enabled", s.enabled, "Uses the depth cameras; off: blind stiffness control.");
  f.choice("source", s.source, {"simulated", "capture", "cloud"},
           "What the cloud is made from. simulated: images rendered of the canvas; capture: the "
           "depth images in perception.capture; cloud: the points in perception.cloud.")
      .for_users();
  f.field("capture", s.capture, "Folder with capture.json and depth images, for source: capture.")
      .for_users();
  f.field("cloud", s.cloud, "File with points in W, in m, .ply, .pcd or .xyz, for source: cloud.")
      .for_users();
  f.field("viewpoint", s.viewpoint, {-100.0, 100.0}, "m",
          "Whence the points of the cloud were seen, x, y, z of one place or of several; empty: as "
          "the file says, or from above.");
  f.field("align", s.align, "Puts the views of a capture onto each other.");
  f.field("find_canvas", s.find_canvas,
          "Leaves out of a capture or a cloud the table, and objects that the drawing does not lie "
          "on.");
  f.field("cameras", s.cameras, "Depth cameras, which take one snapshot before drawing.");
  f.field("noise", s.noise, "Noise of the depth.");
  f.field("errors", s.errors, "Differences of the true cameras from what is believed of them.");
  f.field(
      "stereo", s.stereo,
      "Gives the simulated cameras a stereo camera's faults, of published size: noise that hangs "
      "together, steps, flying pixels, holes, a bias, and a lens that differs from what is "
      "believed of it.");
  f.field(Limits::voxel, s.voxel,
          "Side of the cubes in which points are averaged; 0: every point is kept.");
  f.field("adapt", s.adapt,
          "Uses smaller patches, down to a quarter, where the surface is rougher than noise "
          "explains.");
  f.constant("self_padding", s.self_padding, Range::any(), "m");
  f.field("region_lower", s.region_lower, {-10.0, 10.0}, "m",
          "Lower corner of the region of interest.");
  f.field("region_upper", s.region_upper, {-10.0, 10.0}, "m",
          "Upper corner of the region of interest.");
  f.field("normals", s.normals, "Surface normals from the cloud, equations (18) and (19).");
  f.field("frames", s.frames, "Frames of cameras that keep capturing.");
  f.field("fiducials", s.fiducials, "Marks that tell where the canvas is.");
  f.field(kWatchLimit, s.watch,
          "Time for which the arm watches the canvas before the first stroke.");
  f.choice("canvas_pose", s.canvas_pose, {"tracked", "true"},
           "Where the pose of a moving canvas comes from. tracked: the frames; true: the "
           "simulator, to judge the controller alone.");
}

// The settings of a scenario under `control`.
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
  using Estimator = JointStateEstimatorSettings;
  f.choice("velocity", s.velocity, {"measured", "estimated"},
           "Joint velocities of the control law: as measured, or estimated from the positions, the "
           "torques and the arm's model.");
  f.field("bandwidth", s.bandwidth, Estimator::kBandwidth, "rad/s",
          "Bandwidth of the estimator. Noise of the positions, as measured, lowers it to 150 rad/s "
          "at the most, or as far as the stability checks allow.");
  f.constant("least_bandwidth", s.least_bandwidth, Range::any(), "rad/s");
  f.field("sensor_delay", s.sensor_delay, Estimator::kDelay, "s",
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
  f.field("torque_delay", s.torque_delay, {0.0, 0.02}, "s", "Delay of the drives; null: none.");
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
  f.field("joint_speed_share", s.joint_speed_share, {0.01, 1.0}, "",
          "Share of the arm's joint speed limits that the law may ask for; faster joints are "
          "damped.");
  f.field("check_rotors", s.check_rotors,
          "Refuses a simulated arm whose rotors differ from arm.rotor_inertia by more than the law "
          "bears.");
}

}  // namespace impedraw
