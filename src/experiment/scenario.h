// The complete settings of an experiment: drawing, canvas, perception, control law and world. The
// struct mirrors its YAML file (settings.h). The initialisers give the standard bowl, drawing and
// arm.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/control/impedance_settings.h"
#include "impedraw/drawing/hatch.h"
#include "impedraw/drawing/placement.h"
#include "impedraw/drawing/stroke_file.h"
#include "impedraw/drawing/text.h"
#include "impedraw/experiment/canvas_settings.h"
#include "impedraw/experiment/faults.h"
#include "impedraw/experiment/wrench_input.h"
#include "impedraw/log/log_settings.h"
#include "impedraw/perception/cloud.h"
#include "impedraw/perception/normals.h"
#include "impedraw/planning/path/tip_planner.h"
#include "impedraw/planning/preflight/preflight.h"
#include "impedraw/planning/wrap/wrap.h"
#include "impedraw/report/picture.h"
#include "impedraw/settings/schema.h"
#include "impedraw/simulation/world.h"

namespace impedraw {

// Maps the drawing plane to the surface: by projection along the plane's normal, or by a wrap that
// preserves lengths.
enum class Mapping { project, wrap };

struct DrawingSettings {
  std::string shape = "sine";  // built in; used where svg and text are empty
  std::filesystem::path svg;
  TextSettings text;
  PageUnit unit = PageUnit::file;  // of a stroke file's numbers
  // Joins stroke ends of a file that are closer than this [mm on the page]; 0: off.
  double join_gap_mm = 0.0;
  bool dashes = true;        // of an SVG's strokes
  HatchSettings hatch;       // of an SVG's fills
  double simplify_mm = 0.0;  // tolerance for removing points [mm on the page]
  // Draws a file's strokes in the listed order, instead of one with short pen-up moves.
  bool keep_order = false;
  PlacementSettings placement;
  // Roll, pitch, yaw of the drawing plane. placement.centre is in this plane.
  Eigen::Vector3d tilt_deg = Eigen::Vector3d::Zero();
  Mapping mapping = Mapping::project;
  WrapSettings wrap;
  bool skip_unreachable = false;  // omits what fails the pre-flight; else nothing is drawn
  bool redraw = true;             // redraws once what got no ink
};

struct ArmSettings {
  std::filesystem::path urdf;    // empty: models/iiwa14_pen.urdf
  Eigen::VectorXd posture_seed;  // inverse kinematics starts here and stays near [rad]
  // Rest posture of the null space (14) [rad]; empty: at the middle of the drawing.
  std::vector<double> q_0;
  // Tip position at the snapshot and at the start [m].
  Eigen::Vector3d start_p_WE{0.45, 0.0, 0.50};

  ArmSettings() : posture_seed(7) { posture_seed << 0.0, 0.6, 0.0, -1.4, 0.0, 1.1, 0.0; }
};

struct CameraSettings {
  Eigen::Vector3d p_WC{1.1, 0.0, 0.9};
  Eigen::Vector3d target_W{0.6, 0.0, 0.1};
  int width = 640, height = 480;
  double fov_y_deg = 60.0;
};

struct PerceptionSettings {
  bool enabled = true;
  std::vector<CameraSettings> cameras;  // the standard three
  DepthNoise noise;
  double voxel = 0.004;
  bool adapt = true;  // finer patches where the surface is rough
  double self_padding = 0.01;
  Eigen::Vector3d region_lower{0.25, -0.45, 0.0}, region_upper{1.0, 0.45, 0.60};
  NormalSettings normals;

  PerceptionSettings();
};

enum class BlindHeight { canvas, plane };  // the assumed height without perception

struct BlindSettings {
  BlindHeight height = BlindHeight::canvas;
  double plane_z = 0.09;  // [m]
};

// The control law and the source of its wrench. control.wrench, dt, torque limits and joint ranges
// follow from the other settings and the arm.
struct ControlSettings : ImpedanceSettings {
  WrenchSource source = WrenchSource::truth;
  SensingSettings sensing;
  double torque_share = 1.0;    // of the arm's torque limits
  double torque_rate = 4000.0;  // of every joint [Nm/s]
  // Of the drives [s]. If set, timing.loop_delay is raised to at least one step more.
  std::optional<double> torque_delay;

  ControlSettings() {
    surface.pen_axis = PenAxis::plan;
    null_space.stiffness = Eigen::VectorXd::Constant(7, 10.0);
  }  // the iiwa's
};

// A push on the pen, like that of a hand.
struct PushSettings {
  double force = 10.0;  // [N]
  // Projected onto the canvas's tangent plane under the pen.
  Eigen::Vector3d direction_W = Eigen::Vector3d::UnitX();
  double lift = 0.0;  // additional force along the canvas's outward normal [N]
  // Time, as a fraction of the time from the first stroke's start to the last stroke's end.
  double middle = 0.5;
  double duration = 1.0;  // [s]
};

struct Scenario {
  std::string name = "run";
  int seed = 1;
  DrawingSettings drawing;
  CanvasSettings canvas;
  ArmSettings arm;
  PerceptionSettings perception;
  BlindSettings blind;
  PathSettings path;
  PreflightSettings preflight;
  ControlSettings control;
  WorldSettings world;
  WrenchSensorSettings wrench_sensor;
  PenSettings pen;
  LogSettings log;
  std::vector<PushSettings> pushes;
  std::vector<FaultSettings> faults;
};

void describe(Fields& f, Scenario& s);

}  // namespace impedraw
