// The complete settings of an experiment: drawing, canvas, perception, control law and world. The
// struct mirrors its YAML file (settings.h). The initialisers give the standard bowl, drawing and
// arm.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/control/impedance_settings.h"
#include "impedraw/control/joint_speed_shares.h"
#include "impedraw/drawing/hatch.h"
#include "impedraw/drawing/layers.h"
#include "impedraw/drawing/placement.h"
#include "impedraw/drawing/stroke_file.h"
#include "impedraw/drawing/text.h"
#include "impedraw/experiment/canvas_settings.h"
#include "impedraw/ink/pen.h"
#include "impedraw/log/log_settings.h"
#include "impedraw/perception/cloud.h"
#include "impedraw/perception/frame_settings.h"
#include "impedraw/perception/normals.h"
#include "impedraw/planning/path/tip_planner.h"
#include "impedraw/planning/preflight/preflight.h"
#include "impedraw/planning/wrap/wrap.h"
#include "impedraw/sensing/joint_state_estimator.h"
#include "impedraw/sensing/touch_settings.h"
#include "impedraw/sensing/wrench_estimator.h"
#include "impedraw/settings/schema.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

// Faults injected into the loop around the controller, to test how the arm reacts.
enum class FaultKind {
  nan_state,     // a joint velocity is NaN
  stale_state,   // the joint state stays as it was when the fault began
  nan_wrench,    // the wrench is NaN
  stale_wrench,  // the wrench stays as it was when the fault began
  no_cloud,      // perception finds no surface under the tip
  no_frames,     // the cameras' frames of a moving canvas get lost
  slow_step,     // one control step takes `duration`; the drives hold the last torque
  // An arm and a sensor that lie:
  jumped_state,    // the first joint's position is 0.5 rad off
  drifting_state,  // the first joint's position drifts by 0.3 rad/s, which its speed does not tell
  standing_state,  // positions as they were when the fault began, speeds zero
  false_speed,     // the first joint's speed is 9 rad/s
  false_wrench,    // 200 N more along z
  future_wrench,   // the wrench is stamped an hour ahead
};

struct FaultSettings {
  FaultKind kind = FaultKind::nan_state;
  // Start, as a fraction of the time from the first stroke's start to the last stroke's end.
  double start = 0.5;
  double duration = 0.05;  // [s]
};

// The tool at the arm's end, and how an area is covered with it.
enum class ToolKind { pen, pad, engraver, blade, roller, nozzle };
// As settings and messages call them.
inline constexpr const char* kToolNames[] = {"pen", "pad", "engraver", "blade", "roller", "nozzle"};
enum class Swivel { spot, lifted };  // of a tool that is led, at corners

struct ToolSettings {
  ToolKind kind = ToolKind::pen;
  std::optional<double> radius;                     // of the face; absent: see settings.md [m]
  double foam_stiffness = PadSettings().stiffness;  // [N/m³]
  int joints = 0;                                   // of a pad, passive
  double pivot = 0.0;                               // of their centre behind its disc [m]
  double depth = 0.3e-3;                            // of an engraver's groove [m]
  double half_angle_deg = 45.0;                     // of its cone
  int passes = 1;                                   // to that depth, after a shallow one
  double hardness = 1.0;                            // of the true material, over the believed one
  double yaw_deg = 0.0;                             // of what is led, from the line
  double trail = 0.0;                               // of its face behind the arm's axis [m]
  Swivel swivel = Swivel::spot;
  double stand_off = 0.1;  // of a nozzle from the surface, along its jet [m]
};

// Its heading is led along the lines (tool_fit.h).
inline bool is_led(const ToolSettings& tool) {
  return tool.kind == ToolKind::blade || tool.kind == ToolKind::roller;
}

// Distance by which the frame E lies before the tip of arm.urdf: a nozzle's jet meets the surface
// there [m].
inline double stand_off_of(const ToolSettings& tool) {
  return tool.kind == ToolKind::nozzle ? tool.stand_off : 0.0;
}

// The jet of a nozzle as a foam of even pressure that is as wide, so that it is laid out and judged
// as a pad is; nothing for another tool. `force`: any, of which the pressure is a measure [N].
std::optional<PadSettings> jet_of(const ToolSettings& tool, double force);

// The pad of these settings, which lies level with E under `force` [N]; nothing for another tool.
std::optional<PadSettings> pad_of(const ToolSettings& tool, double friction, double force);

// The cutter of these settings in the believed material; nothing for another tool.
std::optional<CutterSettings> cutter_of(const ToolSettings& tool);

// Depths of an engraver's passes, the shallow one that finds the surface first [m].
std::vector<double> depths_of(const ToolSettings& tool);

enum class CoverDose { even, by_tone };

struct CoverSettings {
  std::filesystem::path
      region;                   // an SVG whose filled areas are covered; empty: all that is reached
  double overlap = 0.82;        // of neighbouring lines, as a share of the footprint's width
  double direction_deg = 90.0;  // of the lines, from the drawing plane's x axis
  double margin = 5e-4;         // that the footprint keeps from edges [m]
  int passes = 1;
  CoverDose dose = CoverDose::even;
};

// The source of the controller's wrench, and the assumed properties of its sensor.
enum class WrenchSource {
  none,       // not measured
  truth,      // the simulator's true wrench, one step old
  sensor,     // a sensor with the errors of world.wrench_sensor, none by default
  realistic,  // a sensor with the errors of a real one: WrenchSensorSettings::realistic()
};

inline bool has_sensor(WrenchSource source) {
  return source == WrenchSource::sensor || source == WrenchSource::realistic;
}

// The controller's assumptions about the sensor and its tool.
struct SensingSettings {
  Tool tool{0.05,
            {0.0, 0.0, 0.06},
            Eigen::Vector3d(6e-5, 6e-5, 6.25e-7).asDiagonal()};  // the pen of models/
  static constexpr double tip_distance =
      0.12;                            // of the tip E from the sensor's origin, along the pen [m]
  std::optional<double> sensor_delay;  // absent: the true delay [s]
  static constexpr double tare_time = 0.4;  // [s]
};

// Estimator settings for the time step dt [s] and the given sensor.
WrenchEstimatorSettings estimator_settings(const SensingSettings& sensing,
                                           const WrenchSensorSettings& sensor, double dt,
                                           double gravity);

// Maps the drawing plane to the surface: by projection along the plane's normal, or by a wrap that
// preserves lengths.
enum class Mapping { project, wrap };

struct DrawingSettings {
  std::string shape = "sine";  // built in; used where svg and text are empty
  std::filesystem::path svg;
  TextSettings text;
  PageUnit unit = PageUnit::file;         // of a stroke file's numbers
  Visible visible = Visible::as_painted;  // of an SVG
  LayerSource layers = LayerSource::automatic;
  std::string layer;    // numbers and names of the layers that are drawn; empty: all
  HatchSettings hatch;  // of an SVG's fills
  // Draws a file's strokes in the listed order, instead of one with short pen-up moves.
  bool keep_order = false;
  PlacementSettings placement;
  // Roll, pitch, yaw of the drawing plane. placement.centre is in this plane.
  Eigen::Vector3d tilt_deg = Eigen::Vector3d::Zero();
  Mapping mapping = Mapping::project;
  WrapSettings wrap;
  bool skip_unreachable = false;  // omits what fails the pre-flight; else nothing is drawn
  bool redraw = true;             // redraws once what got no ink
  // Height above the surface at which the drawing is gone through in the air [m]; none: no dry run.
  std::optional<double> dry_run;
};

// Who moves the arm, and whose clock the loop follows.
enum class ArmDriver { sim, iiwa_lcm, franka };
enum class ArmClock {
  wall,       // the arm's state comes when it comes
  lock_step,  // the arm waits for the command that answers its state: simulators
};

struct ArmSettings {
  ArmDriver driver = ArmDriver::sim;
  // The settings up to recoveries are for an arm that is not simulated here.
  std::string url = "tcpq://127.0.0.1:7701";  // of the broker, or of the arm
  ArmClock clock = ArmClock::wall;
  double delay = 1e-3;         // from a state to the torque that answers it acting [s]
  double wrench_delay = 2e-3;  // age of the wrench at the tip when it arrives [s]
  double max_silence = 0.05;   // without a state, by the wall clock; then the session ends [s]
  int recoveries = 3;          // from reflexes of the arm, in one run
  // On a wall clock: the loop's thread asks for SCHED_FIFO and locked memory (run/real_time.h).
  bool real_time = true;

  std::filesystem::path urdf;  // empty: models/iiwa14_pen.urdf
  // As the controller's model has it, of all joints or of each; empty: what the URDF says [kg m²].
  std::vector<double> rotor_inertia;
  // Springs in the joints and the arm's own torque loop, as the set-up knows them (experiment.cc):
  // of all joints or of each, empty: rigid [Nm/rad]; 0: no loop [rad/s].
  std::vector<double> joint_stiffness;
  double torque_bandwidth = 0.0;
  // The inverse kinematics of the start starts here and stays near, one entry per joint [rad];
  // empty: see start_posture.h.
  std::vector<double> posture_seed;
  // Rest posture of the null space (14) [rad]; empty: at the middle of the drawing.
  std::vector<double> q_0;
  // Tip position at the snapshot and at the start [m].
  Eigen::Vector3d start_p_WE{0.45, 0.0, 0.50};
};

// Limits whose violation ends a run at once, with any arm (run/monitors/fence_monitor.h).
struct FenceSettings {
  // The box that the tip must stay in, W [m].
  Eigen::Vector3d low{-2.0, -2.0, -2.0}, high{2.0, 2.0, 2.0};
  // Measured, of the canvas on the tip [N], [Nm]; none: 150 N and 30 Nm, where it is measured.
  std::optional<double> force, moment;
  std::optional<double> speed;  // of the tip [m/s]; none: no fence
  double lag = 0.2;             // of the tip behind the point that it is driven to [m]
};

struct CameraSettings {
  Eigen::Vector3d p_WC{1.1, 0.0, 0.9};
  Eigen::Vector3d target_W{0.6, 0.0, 0.1};
  int width = 640, height = 480;
  double fov_y_deg = 60.0;

  using Limits = DepthCamera::Limits;
};

// Differences of the true cameras from what is believed of them. The directions of each camera's
// shift and turn come from the seed.
struct CameraErrors {
  double shift = 0.0;        // of its position [m]
  double turn_deg = 0.0;     // about an axis through its pinhole
  double depth_scale = 0.0;  // depths read 1 + depth_scale times the true ones
  double time_stamp = 0.0;   // a frame's time stamp is later than its exposure by this [s]
};

// The source of perception's cloud.
enum class PerceptionSource {
  simulated,  // depth images that are rendered of the true canvas
  capture,    // a folder of depth images of real cameras, or of another renderer
  cloud,      // a file of points
};

struct PerceptionSettings {
  bool enabled = true;
  PerceptionSource source = PerceptionSource::simulated;
  std::filesystem::path capture;        // the folder (capture/capture.h)
  std::filesystem::path cloud;          // the file (capture/cloud_file.h)
  std::vector<double> viewpoint;        // of `cloud`, W, three numbers each [m]; may be empty
  std::vector<CameraSettings> cameras;  // the standard three
  DepthNoise noise;
  CameraErrors errors;
  double voxel = 0.004;
  bool adapt = true;  // finer patches where the surface is rough
  // For a capture: puts its views onto each other (capture/view_alignment.h).
  bool align = true;
  // For a capture or a cloud: leaves out the table, and what the drawing does not lie on
  // (capture/found_canvas.h).
  bool find_canvas = true;
  bool stereo = false;  // simulated cameras have a stereo camera's faults (stereo_faults.h)
  double self_padding = 0.01;
  Eigen::Vector3d region_lower{0.25, -0.45, 0.0}, region_upper{1.0, 0.45, 0.60};
  NormalSettings normals;
  FrameSettings frames;
  FiducialSettings fiducials;
  double watch = kWatchTime;  // before the first stroke, if there are frames [s]
  CanvasPoseSource canvas_pose = CanvasPoseSource::tracked;

  using Limits = CloudSettings::Limits;

  PerceptionSettings();
};

// Knowledge of the surface's height without perception: all of it, or only that it lies between
// two levels. Then the law is the paper's, with a set-point on the lower level and a stiffness that
// makes the push, or the surface is found and followed by touch (touch_surface.h).
enum class BlindHeight { canvas, plane, touch };

struct BlindSettings {
  BlindHeight height = BlindHeight::canvas;
  double plane_z = 0.02;  // the lower level, along the drawing axis [m]
  double top_z = 0.20;    // the upper level [m]
  TouchSettings touch;
};

enum class VelocitySource {
  measured,   // as the joints' sensors give it
  estimated,  // from their positions: joint_state_estimator.h
};

// The controller's assumptions about the joints' sensors.
struct JointSensingSettings {
  VelocitySource velocity = VelocitySource::measured;
  double bandwidth = JointStateEstimatorSettings().bandwidth;  // of the estimator [rad/s]
  double least_bandwidth = JointStateEstimatorSettings().least_bandwidth;  // with noise [rad/s]
  std::optional<double> sensor_delay;  // absent: the true delay [s]
};

// FeltNormalSettings of a scenario.
struct GivenFeltNormal {
  std::optional<double> share;  // none: by the surface's roughness (plan_notes.h)
  double deviation = FeltNormalSettings().deviation;
  double force_error = FeltNormalSettings().force_error;
};

// bandwidth: none: that of ObserverSettings, faster where the description has dry friction
// (scene.cc).
struct GivenObserver : ObserverSettings {
  std::optional<double> bandwidth;  // [rad/s]
};

// The control law and the source of its wrench. control.wrench, dt, torque limits, joint ranges and
// null_space.stiffness follow from the other settings and the arm.
struct ControlSettings : ImpedanceSettings {
  WrenchSource source = WrenchSource::truth;
  SensingSettings sensing;
  JointSensingSettings joint_sensing;
  // By the surface's roughness (plan_notes.h) where they are absent.
  std::optional<PenAxis> pen_axis;
  std::optional<double> normal_error_deg;
  GivenFeltNormal felt_normal;
  GivenObserver observer;
  // Along the normal, for inertia: shaped; absent: the least of shaped_inertia, or more where the
  // wrench comes late (control_setup.cc) [kg].
  std::optional<double> mass_normal;
  double torque_share = 1.0;                          // of the arm's torque limits
  double torque_rate = 4000.0;                        // of every joint [Nm/s]
  double joint_speed_share = JointSpeedShares::kLaw;  // of the arm's joint speed limits
  bool check_rotors = true;  // refuses what the law would not bear (experiment.cc)
  // Delay of the drives [s]; none: 0. timing.loop_delay is one step more.
  std::optional<double> torque_delay;
  // Stiffness of the null space, one entry per joint [Nm/rad]; empty: 10 Nm/rad on each joint.
  std::vector<double> null_stiffness;
};

// A push on the pen or on a link of the arm, like that of a hand.
struct PushSettings {
  double force = 10.0;  // [N]
  std::string link;     // pushed at its origin; empty: the pen at its tip
  // On the pen: projected onto the canvas's tangent plane under it.
  Eigen::Vector3d direction_W = Eigen::Vector3d::UnitX();
  double lift = 0.0;  // additional force along the canvas's outward normal [N]
  // Time, as a fraction of the time from the first stroke's start to the last stroke's end.
  double middle = 0.5;
  double duration = 1.0;  // [s]
};

// The pen of `pen`, and how it is changed for one of `pens` (pen_changes.h).
struct GivenPen : PenSettings {
  bool check = false;                    // a pen that is put in touches `spot`, for its length
  std::optional<Eigen::Vector3d> spot;   // W [m]; absent: where the drawing begins
  std::optional<Eigen::Vector3d> place;  // where pens are changed, W [m]; absent: the arm's start
};

// The pen of a layer. What is absent is that of `pen`, `control` and `path`, or of the artwork.
struct LayerPenSettings {
  std::string layer;            // its number or name, as for --layer
  std::string colour;           // of its ink: a name or #rrggbb; empty: the artwork's
  std::optional<double> force;  // of lines without a width of their own [N]
  std::optional<double> speed;  // [m/s]
  std::optional<double> width, width_per_newton, nominal_force;  // as in PenSettings
  std::optional<double> longer;  // its tip beyond that of arm.urdf, along the pen [m]
  std::optional<double> radius;  // of its tip; absent: control.tip.radius, world.tip.radius [m]

  bool operator==(const LayerPenSettings&) const = default;
};

struct Scenario {
  std::string name = "run";
  int seed = 1;
  DrawingSettings drawing;
  CanvasSettings canvas;
  ArmSettings arm;
  FenceSettings fence;
  PerceptionSettings perception;
  BlindSettings blind;
  PathSettings path;
  PreflightSettings preflight;
  ControlSettings control;
  WorldSettings world;
  WrenchSensorSettings wrench_sensor;
  GivenPen pen;
  std::vector<LayerPenSettings> pens;
  ToolSettings tool;
  CoverSettings cover;
  LogSettings log;
  std::vector<PushSettings> pushes;
  std::vector<FaultSettings> faults;
};

// The simulated world is made of what was seen: there is no truth to judge against.
bool is_rehearsal(const Scenario& scenario);

// Something touches the canvas: no nozzle is held, and the drawing is no dry run.
inline bool touches(const Scenario& s) {
  return !s.drawing.dry_run && s.tool.kind != ToolKind::nozzle;
}

// The tool, as messages call it.
inline const char* name_of_tool(const Scenario& s) {
  return kToolNames[static_cast<std::size_t>(s.tool.kind)];
}

// The tip in the simulated world: world.tip, or a jet that presses on nothing.
TipMaterial true_tip(const Scenario& scenario);

// The face of a tool, which lies level with E under control.normal_force: a pad, the edge of a
// blade in the believed material, a roller. Nothing for a pen and an engraver.
std::optional<PadSettings> face_of(const Scenario& scenario);

void describe(Fields& f, Scenario& s);

}  // namespace impedraw
