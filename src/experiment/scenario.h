// One experiment, all of it: what is drawn, on what, seen how, by which law, in which world. The
// struct is its YAML file (settings.h); its initialisers are the standard bowl, drawings and arm.
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

// From the page laid on the drawing plane to the surface: straight along the plane's axis, or by a
// wrap that keeps lengths.
enum class Mapping { project, wrap };

struct DrawingSettings {
  std::string shape = "sine";  // built in; used where svg and text are empty
  std::filesystem::path svg;
  TextSettings text;
  PageUnit unit = PageUnit::file;  // of a stroke file's numbers
  // of a file: ends that lie so near to one another are joined [mm on the page]; 0: none are
  double join_gap_mm = 0.0;
  bool dashes = true;        // of an SVG's strokes
  HatchSettings hatch;       // of its fills
  double simplify_mm = 0.0;  // points are left out that lie so near to the rest [mm on the page]
  // of a file: drawn as it lists its strokes, not with short ways in the air
  bool keep_order = false;
  PlacementSettings placement;
  Eigen::Vector3d tilt_deg = Eigen::Vector3d::
      Zero();  // roll, pitch, yaw of the drawing plane; placement.centre lies in it
  Mapping mapping = Mapping::project;
  WrapSettings wrap;
  bool skip_unreachable = false;  // what fails the pre-flight is left out; else nothing is drawn
  bool redraw = true;             // what got no ink is drawn once more
};

struct ArmSettings {
  std::filesystem::path urdf;    // empty: models/iiwa14_pen.urdf
  Eigen::VectorXd posture_seed;  // inverse kinematics start here and stay near [rad]
  std::vector<double>
      q_0;  // rest posture of the null space (14) [rad]; empty: over the middle of the drawing
  Eigen::Vector3d start_p_WE{0.45, 0.0,
                             0.50};  // where the tip is at the snapshot and at the start [m]

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
  double self_padding = 0.01;
  Eigen::Vector3d region_lower{0.25, -0.45, 0.0}, region_upper{1.0, 0.45, 0.60};
  NormalSettings normals;

  PerceptionSettings();
};

enum class BlindHeight { canvas, plane };  // what is known of the height when nothing is seen

struct BlindSettings {
  BlindHeight height = BlindHeight::canvas;
  double plane_z = 0.09;  // [m]
};

// The law, and where its wrench comes from. control.wrench, dt and what the arm sets (torque
// limits, joint ranges) follow from the rest.
struct ControlSettings : ImpedanceSettings {
  WrenchSource source = WrenchSource::truth;
  SensingSettings sensing;
  double torque_share = 1.0;    // of the arm's torque limits
  double torque_rate = 4000.0;  // of every joint [Nm/s]
  // Of the drives [s]: says that timing.loop_delay is at least one step longer.
  std::optional<double> torque_delay;

  ControlSettings() { null_space.stiffness = Eigen::VectorXd::Constant(7, 10.0); }  // the iiwa's
};

// A push on the pen, as a hand would.
struct PushSettings {
  double force = 10.0;  // [N]
  // taken along the canvas's tangent plane under the pen
  Eigen::Vector3d direction_W = Eigen::Vector3d::UnitX();
  double lift = 0.0;  // and this along the canvas's outward normal [N]
  // when: this share of the way from the first stroke's start to the last one's end
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
