#include "impedraw/experiment/scenario.h"

#include <cmath>
#include <numbers>

#include "impedraw/control/describe_control.h"
#include "impedraw/planning/describe_path.h"
#include "impedraw/planning/preflight/describe_preflight.h"
#include "impedraw/sensing/describe_touch.h"
#include "impedraw/simulation/blade_law.h"
#include "impedraw/simulation/describe_world.h"

namespace impedraw {

WrenchEstimatorSettings estimator_settings(const SensingSettings& sensing,
                                           const WrenchSensorSettings& sensor, double dt,
                                           double gravity) {
  WrenchEstimatorSettings s;
  s.dt = dt;
  s.tool = sensing.tool;
  s.X_ES.p = {0.0, 0.0, -sensing.tip_distance};
  s.gravity_W = {0.0, 0.0, -gravity};
  s.sensor_delay = sensing.sensor_delay.value_or(sensor.delay);
  s.tare_time = sensing.tare_time;
  // A reading at the end of the range is rounded to a whole quantum, which may lie below it.
  if (sensor.range_force > 0.0) s.range_force = sensor.range_force - sensor.quantum_force;
  if (sensor.range_torque > 0.0) s.range_torque = sensor.range_torque - sensor.quantum_torque;
  return s;
}

PerceptionSettings::PerceptionSettings() {
  for (const double azimuth : {0.0, 2.0 * std::numbers::pi / 3.0, 4.0 * std::numbers::pi / 3.0}) {
    CameraSettings camera;
    camera.p_WC = {0.6 + 0.5 * std::cos(azimuth), 0.5 * std::sin(azimuth), 0.9};
    cameras.push_back(camera);
  }
}

void describe(Fields& f, PlacementSettings& s) {
  using Limits = PlacementSettings::Limits;
  f.field(Limits::centre, s.centre_m,
          "Where the middle of the drawing goes in the drawing plane (x, y).")
      .for_users();
  f.field(Limits::scale, s.scale,
          "Millimetres on the canvas per millimetre on the page; null: set by one of the sizes.");
  f.field(Limits::width, s.width_mm,
          "Size of the drawing across the page; null: set by another size.")
      .for_users();
  f.field(Limits::height, s.height_mm,
          "Size of the drawing down the page; null: set by another size.")
      .for_users();
  f.field(Limits::fit_width, s.fit_width_m,
          "Width, along world y, of a rectangle that the drawing is scaled to fill; null: no bound "
          "that way.");
  f.field(
      Limits::fit_height, s.fit_height_m,
      "Height, along world x, of a rectangle that the drawing is scaled to fill; null: no bound "
      "that way.");
  f.field(Limits::margin, s.margin_mm, "Space left free on each side of the rectangle.");
  f.field("fit_page", s.fit_page,
          "Fits the whole page into the rectangle instead of the bounding box of the strokes.");
  f.field(
      Limits::fit_radius, s.fit_radius_m,
      "Radius of the circle on which the farthest stroke point lies if no other size is given.");
  f.field("about_page_origin", s.about_page_origin,
          "Puts the page's (0, 0) at the centre instead of the middle of the strokes.");
  f.field(Limits::rotate, s.rotate_deg,
          "Rotation of the drawing, counter-clockwise as seen from above.")
      .for_users();
  f.field("mirror", s.mirror, "Mirrors the drawing left to right.");
}

void describe(Fields& f, TextSettings& s) {
  using Limits = TextSettings::Limits;
  f.field("text", s.text,
          "Text to write in single strokes; \\n starts a new line; empty: the file or the shape is "
          "drawn.")
      .for_users();
  f.field("font", s.font,
          "Hershey font: futural, rowmans, scripts, gothiceng, ... (/usr/share/hershey-fonts); or "
          "the path of an SVG 1.1 font (.svg).")
      .for_users();
  f.field(Limits::size, s.size_mm,
          "Height of the capitals, on the canvas if the placement gives no size; null: the text is "
          "fitted as a file is.")
      .for_users();
  f.choice("as", s.as, {"outline", "single"},
           "How the text of an SVG is drawn. outline: as the outlines of its fonts' letters; "
           "single: in single strokes of drawing.text.font.")
      .for_users();
  f.choice("align", s.align, {"left", "centre", "right"}, "Alignment of the lines.");
  f.field(Limits::line_spacing, s.line_spacing,
          "Distance between baselines, as a multiple of the capitals' height.");
}

void describe(Fields& f, HatchSettings& s) {
  using Limits = HatchSettings::Limits;
  f.field(Limits::spacing, s.spacing_mm,
          "Distance, on the canvas, between the lines that stand for a fill; 0: fills are not "
          "hatched. White is never hatched. On slopes, too: the lines of a projected drawing bend "
          "where the surface does. Lighter fills have wider ones: a medium grey twice as wide as "
          "black.")
      .for_users();
  f.choice(
       "style", s.style, {"boustrophedon", "concentric", "contour-parallel"},
       "boustrophedon: parallel lines, drawn to and fro. concentric: circles about the middle of "
       "each area. contour-parallel: rings that follow each area's outline inwards.")
      .for_users();
  f.field(Limits::angle, s.angle_deg,
          "Angle of the lines to the page's X axis, counter-clockwise.");
  f.field("cross", s.cross, "Adds a second set of lines at right angles.");
  f.field("outline", s.outline, "Draws the outlines of areas that are filled but not stroked.");
}

void describe(Fields& f, WrapSettings& s) {
  f.constant("spacing", s.spacing, Range::any(), "m");
  f.constant("margin", s.margin, Range::any(), "m");
  f.constant("tolerance", s.tolerance, Range::any(), "m");
}

void describe(Fields& f, DrawingSettings& s) {
  f.field("shape", s.shape,
          "Built-in drawing: sine, M, sine10 or circle. It is used if svg and text are empty.")
      .for_users();
  f.field("svg", s.svg,
          "File to draw: .svg, or strokes as .txt, .strokes or .csv; empty: the shape is drawn.")
      .for_users();
  f.field("text", s.text, "Text that is written instead of a file or shape.");
  f.choice("unit", s.unit, {"file", "mm", "cm", "in", "m", "px"},
           "Unit of the numbers in .txt, .strokes and .csv files; file: millimetres, or fractions "
           "of the page if all numbers lie between 0 and 1.");
  f.choice("visible", s.visible, {"as-painted", "all"},
           "What of an SVG is drawn. as-painted: what the eye sees; opaque fills, clip paths and "
           "masks hide lines, and white is not drawn. all: every line, as if nothing were hidden.");
  f.choice("layers", s.layers, {"auto", "groups", "colours"},
           "What an SVG's layers are; each is drawn before the next. groups: Inkscape's layers and "
           "other groups at the top of the document. auto: its groups; its colours where there is "
           "one group at most, without a name, and two to eight colours.");
  f.field("layer", s.layer,
          "Layers that are drawn, by number or name, as in '2,black'; empty: all of them.")
      .for_users();
  f.constant("join_gap", 0.0, Range::any(), "mm");
  f.constant("dashes", true);
  f.field("hatch", s.hatch, "Hatching of an SVG's filled areas.");
  f.constant("simplify", 0.0, Range::any(), "mm");
  f.field("keep_order", s.keep_order,
          "Keeps the order of the strokes in the file instead of shortening the travel between "
          "them.");
  f.field(
      "tilt", s.tilt_deg, {-180.0, 180.0}, "deg",
      "Roll, pitch and yaw of the drawing plane about the world's origin; [0, -90, 0] is a wall "
      "that faces the arm.");
  f.choice("mapping", s.mapping, {"project", "wrap"},
           "How the page reaches the surface: projected along the drawing axis, or wrapped like a "
           "sheet, which preserves lengths.")
      .for_users();
  f.field("wrap", s.wrap, "How the surface is flattened for mapping: wrap.");
  f.field("skip_unreachable", s.skip_unreachable,
          "Leaves out and reports what fails the pre-flight; otherwise nothing is drawn.")
      .for_users();
  f.field("redraw", s.redraw,
          "Draws the parts that got no ink, judged by contact and force, once more at the end.");
  f.field("dry_run", s.dry_run, {0.005, 0.3}, "m",
          "Goes through the drawing in the air, at this height above the surface along the drawing "
          "plane's normal, and never seeks contact; null: draws.");
  f.field("placement", s.placement,
          "Placement of the page on the canvas. A built-in shape has scale 1 unless a size is "
          "given.");
}

void describe(Fields& f, ArmSettings& s) {
  f.choice(
       "driver", s.driver, {"sim", "iiwa-lcm", "franka"},
       "Who moves the arm: the simulator here, KUKA's iiwa over LCM, or Franka's FR3 through its "
       "control interface (docs/arms.md).")
      .for_users();
  f.field("url", s.url,
          "iiwa-lcm: the LCM broker, as in tcpq://127.0.0.1:7701. franka: the arm, as in "
          "fci://172.16.0.2.")
      .for_users();
  f.choice("clock", s.clock, {"wall", "lock_step"},
           "Not sim: wall: states come by the arm's own clock; lock_step: the arm is simulated "
           "and waits for the answer to each state.");
  f.field("delay", s.delay, {0.0, 0.02}, "s",
          "Not sim: time from a state until the torque that answers it acts.");
  f.field("wrench_delay", s.wrench_delay, {0.0, 0.02}, "s",
          "iiwa-lcm: age of the wrench at the tip when it arrives, for control.wrench: "
          "ground_truth, which is then what the channel IMPEDRAW_TIP_WRENCH carries.");
  f.field("max_silence", s.max_silence, {0.005, 60.0}, "s",
          "Not sim: time without a state, by the wall clock, after which the session ends.");
  f.field("recoveries", s.recoveries, {0, 100}, "",
          "franka: how often in a run the arm may be asked to recover from a reflex, after which "
          "the drawing goes on. Never after a collision.");
  f.field("real_time", s.real_time,
          "Not sim, clock: wall: the loop's thread asks the system for real-time priority and "
          "locked memory; where it gets none, a note says so.");
  f.field("urdf", s.urdf, "URDF of the arm with its pen; empty: the iiwa 14 in models/.")
      .for_users();
  f.field(kRotorInertia, s.rotor_inertia,
          "Inertia of the rotors about the joints' axes, reflected through their gears, as the "
          "controller's model has it: one for all joints or one for each; empty: what the URDF's "
          "impedraw element says, else none. With torque_bandwidth: what the torque loop leaves of "
          "it, and by default joint_stiffness/torque_bandwidth².")
      .or_one();
  f.field("joint_stiffness", s.joint_stiffness, kSpringStiffnessRange, "Nm/rad",
          "Stiffness of the joints' gears and torque sensors: one for all joints or one for each; "
          "empty: rigid. The set-up rehearses with it what observer the arm bears.")
      .or_one();
  f.field("torque_bandwidth", s.torque_bandwidth, kTorqueLoopRange, "rad/s",
          "Bandwidth of the arm's own torque loop; 0: none.");
  f.field("posture_seed", s.posture_seed, {-3.2, 3.2}, "rad",
          "Joint angles from which the inverse kinematics starts, one per joint; empty: those of "
          "the iiwa for seven joints, else found by a search.");
  f.field("q_0", s.q_0, {-3.2, 3.2}, "rad",
          "Rest posture of the null space, one angle per joint; empty: the posture over the middle "
          "of the drawing.");
  f.field("start", s.start_p_WE, {-10.0, 10.0}, "m",
          "Position of the pen tip during the snapshot and at the start.");
}

void describe(Fields& f, FenceSettings& s) {
  f.field("low", s.low, {-10.0, 10.0}, "m", "Lowest coordinates that the tip may have.");
  f.field("high", s.high, {-10.0, 10.0}, "m", "Highest coordinates that the tip may have.");
  f.field("force", s.force, {1.0, 200.0}, "N",
          "Measured force on the tip that ends the run; null: 150 N, where it is measured. Needs "
          "control.wrench.");
  f.field("moment", s.moment, {0.1, 200.0}, "Nm",
          "Measured moment at the tip that ends the run; null: 30 Nm, where it is measured. Needs "
          "control.wrench.");
  f.field("speed", s.speed, {0.01, 5.0}, "m/s", "Speed of the tip that ends the run; null: none.");
  f.field("lag", s.lag, {0.01, 2.0}, "m",
          "Distance of the tip from the point that it is driven to that ends the run after 0.1 s.");
}

void describe(Fields& f, BlindSettings& s) {
  f.choice("height", s.height, {"canvas", "plane", "touch"},
           "What is known of the surface's height without perception. canvas: all; plane: that it "
           "lies between plane_z, where the set-point is, and top_z; touch: the same, and it is "
           "found and followed by the measured wrench.");
  f.field("plane_z", s.plane_z, {-2.0, 2.0}, "m",
          "Level beneath the surface, along the drawing axis, for height: plane and touch.");
  f.field("top_z", s.top_z, {-2.0, 2.0}, "m",
          "Level above the surface, along the drawing axis, for height: plane and touch.");
  f.field("touch", s.touch, "How the surface is learned from touch, for height: touch.");
}

namespace {

constexpr Range kWidthRange{0.01, 20.0};            // [mm]
constexpr Range kWidthPerNewtonRange{-10.0, 10.0};  // [mm/N]
constexpr Range kNominalForceRange{0.0, 100.0};     // [N]

}  // namespace

void describe(Fields& f, GivenPen& s) {
  f.field("width", s.width, kWidthRange, "mm", "Line width at the nominal force.").for_users();
  f.field("width_per_newton", s.width_per_newton, kWidthPerNewtonRange, "mm/N",
          "Change of the line width with the force; 0: constant width.");
  f.field("nominal_force", s.nominal_force, kNominalForceRange, "N",
          "Force at which the line has its nominal width.");
  f.field("least_force", s.least_force, {0.3, 50.0}, "N",
          "Least force of lines whose width or force is given: by an SVG's stroke-width, where the "
          "width changes with the force, or by a stroke file's column.");
  f.field("most_force", s.most_force, {0.3, 50.0}, "N", "Their greatest force.");
  f.field("check", s.check,
          "After a change to another of pens, touches a known spot and finds the tip's length. "
          "Needs a measured wrench.");
  f.field("spot", s.spot, {-10.0, 10.0}, "m",
          "That spot, in the world; null: where the drawing begins, as the first pen feels it.");
  f.field("place", s.place, {-10.0, 10.0}, "m",
          "Where the tip waits while a pen is changed, in the world; null: where the arm starts.");
}

void describe(Fields& f, LayerPenSettings& s) {
  f.field("layer", s.layer, "Number or name of the layer, as for drawing.layer.");
  f.field("colour", s.colour,
          "Colour of its ink, a name or #rrggbb; empty: that of the layer's first line.");
  f.field("force", s.force, kForceRange, "N",
          "Force of lines without a width of their own; null: control.normal_force.");
  f.field("speed", s.speed, kDrawSpeedRange, "m/s", "Speed of this pen; null: path.draw_speed.");
  f.field("width", s.width, kWidthRange, "mm",
          "Line width at the nominal force; null: that of pen.");
  f.field("width_per_newton", s.width_per_newton, kWidthPerNewtonRange, "mm/N",
          "Change of the line width with the force; null: that of pen.");
  f.field("nominal_force", s.nominal_force, kNominalForceRange, "N",
          "Force at which the line has its nominal width; null: that of pen.");
  f.field("longer", s.longer, kPenLongerRange, "m",
          "Its tip beyond that of arm.urdf, along the pen, as far as is known; null: 0.");
  f.field("radius", s.radius, {1e-5, 0.05}, "m",
          "Radius of its tip; null: control.tip.radius, in the simulated world world.tip.radius.");
}

void describe(Fields& f, ToolSettings& s) {
  f.choice(
      "kind", s.kind, Words(std::begin(kToolNames), std::end(kToolNames)),
      "What touches the canvas. pen: the ball of world.tip. pad: a rigid disc with a layer of "
      "foam. engraver: a turning cone that cuts grooves. blade: an edge that is led along the "
      "lines. roller: a line across them that rolls. nozzle: its jet sprays or dispenses along "
      "them, and nothing touches.");
  f.field("radius", s.radius, kPadRadiusRange, "m",
          "Radius of the pad or of a nozzle's jet on the surface, half the length of a blade's "
          "edge or of a roller; null: 15 mm, and "
          "for a blade as much as the force sinks into the believed material.");
  f.constant("foam_thickness", PadSettings().thickness, Range::any(), "m");
  f.field("foam_stiffness", s.foam_stiffness, kFoamStiffnessRange, "N/m³",
          "Pressure of the foam per compression.");
  f.constant("foam_damping", PadSettings().damping, Range::any(), "N s/m³");
  f.field(
      "joints", s.joints, {0, 2}, "",
      "Passive joints that let a pad turn with the surface: 0: rigid, 1: about x of the tip, 2: "
      "about x and y.");
  f.field("pivot", s.pivot, {-0.02, 0.05}, "m",
          "Distance of these joints' centre behind the pad's rigid disc; negative: before it.");
  f.field("depth", s.depth, {1e-4, 2e-3}, "m", "Depth of the engraver's groove below the surface.");
  f.field("half_angle", s.half_angle_deg, {10.0, 75.0}, "deg",
          "Half of the angle of the engraver's cone; angle of a blade's edge to the surface.");
  f.field("passes", s.passes, {1, 20}, "",
          "Cuts to that depth, in equal steps, after a shallow one that finds the surface.");
  f.field("hardness", s.hardness, {0.2, 5.0}, "",
          "True cutting forces of the simulated material over the believed ones.");
  f.field("yaw", s.yaw_deg, {-180.0, 180.0}, "deg",
          "Angle of a blade or roller from the line, about the surface's normal: a squeegee's 90.");
  f.field("trail", s.trail, {0.0, 0.02}, "m",
          "How far a blade's edge or a roller trails the arm's axis, as a drag knife's.");
  f.choice("swivel", s.swivel, {"spot", "lifted"},
           "How a blade or roller turns at a corner: on the spot, or lifted.");
  f.field("stand_off", s.stand_off, {1e-3, 0.3}, "m",
          "Distance of a nozzle, the tip of arm.urdf, from the surface.");
}

void describe(Fields& f, CoverSettings& s) {
  f.field("region", s.region,
          "SVG whose filled areas are covered, placed as drawing.placement says; or a mesh with "
          "the colour of its faces, placed as canvas.mesh is, as part.ply#c01020; empty: all that "
          "the cameras see and the arm reaches.");
  f.field("overlap", s.overlap, {0.0, 0.9}, "",
          "Overlap of neighbouring lines, as a share of the footprint's width. 0.82 treats evenly "
          "up to the border; 0.69 takes three fifths of its time and is less even.");
  f.field("direction", s.direction_deg, {-360.0, 360.0}, "deg",
          "Direction of the lines in the drawing plane, counter-clockwise from its x axis.");
  f.field("margin", s.margin, {0.0, 0.05}, "m",
          "Distance that the footprint keeps from edges and holes.");
  f.field("passes", s.passes, {1, 100}, "",
          "How often the area is gone over; by_tone: where its tone is full.");
  f.choice("dose", s.dose, {"even", "by_tone"},
           "even: pressure times way, by which a pad removes, is the same everywhere; by_tone: in "
           "proportion to the tone of cover.region, black the most, white nothing.");
}

void describe(Fields& f, LogSettings& s) {
  f.choice("rate", s.rate, {"reduced", "full"},
           "full: everything of every control step; reduced: a sixth of its size, the same "
           "metrics.json, and rows at 62.5 Hz and at the extremes of the force");
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

// Elsewhere: describe_settings.cc.
void describe(Fields& f, PerceptionSettings& s);
void describe(Fields& f, ControlSettings& s);

void describe(Fields& f, Scenario& s) {
  f.field("name", s.name, "Name of the run, and of its folder.").for_users();
  f.field("seed", s.seed, {0, 1e9}, "", "Seed of all random numbers.").for_users();
  f.field("drawing", s.drawing, "What is drawn.");
  f.field("canvas", s.canvas, "The surface that is drawn on.");
  f.field("arm", s.arm, "The robot arm.");
  f.field("fence", s.fence,
          "What ends a run at once: the arm damps its motion, then stands, and incident.html tells "
          "the last two seconds.");
  f.field("perception", s.perception, "How the canvas is seen.");
  f.field("blind", s.blind, "Control without perception.");
  f.field("path", s.path, "Motion of the pen tip.");
  f.field("preflight", s.preflight, "Checks before anything moves.");
  f.field("control", s.control, "The control law.");
  f.field("world", s.world, "The simulated world.");
  f.field("wrench_sensor", s.wrench_sensor,
          "Faults of the sensor between flange and pen, for control.wrench: sensor.");
  f.field("pen", s.pen, "The line that the pen leaves in the pictures.");
  f.field("tool", s.tool, "What the arm holds.");
  f.field("cover", s.cover, "What ./impedraw cover treats, and how.");
  f.field("log", s.log, "How much of the run the log keeps.");
  f.field("pens", s.pens, "Pens of layers of their own.");
  f.field("pushes", s.pushes, "Pushes on the pen or the arm, as by a hand.");
  f.field("faults", s.faults, "Faults that are injected on purpose.");
}

bool is_rehearsal(const Scenario& s) {
  return s.canvas.kind == CanvasKind::seen && s.arm.driver == ArmDriver::sim;
}

namespace {

PadSettings foam_of(const ToolSettings& tool, double friction, double force) {
  PadSettings pad;
  pad.radius = tool.radius.value_or(pad.radius);
  pad.stiffness = tool.foam_stiffness;
  pad.friction = friction;
  pad.rest = force / (pad.stiffness * pad.area());
  return pad;
}

}  // namespace

std::optional<PadSettings> pad_of(const ToolSettings& tool, double friction, double force) {
  if (tool.kind != ToolKind::pad) return std::nullopt;
  PadSettings pad = foam_of(tool, friction, force);
  pad.joints = tool.joints;
  pad.pivot = tool.pivot;
  return pad;
}

std::optional<PadSettings> jet_of(const ToolSettings& tool, double force) {
  if (tool.kind != ToolKind::nozzle) return std::nullopt;
  constexpr double kDeep = 1.0;  // so deep in a foam, unevenness does not count [m]
  PadSettings jet;
  jet.radius = tool.radius.value_or(jet.radius);
  jet.rest = kDeep;
  jet.stiffness = force / (jet.area() * kDeep);
  return jet;
}

TipMaterial true_tip(const Scenario& s) {
  TipMaterial tip = s.world.tip;
  if (s.tool.kind == ToolKind::nozzle) tip.stiffness = tip.damping = tip.friction = 0.0;
  return tip;
}

std::optional<PadSettings> face_of(const Scenario& s) {
  const double force = s.control.normal_force;
  if (s.tool.kind == ToolKind::blade) {
    BladeSettings blade;
    blade.angle = s.tool.half_angle_deg * std::numbers::pi / 180.0;
    PadSettings edge = blade_edge(blade, s.tool.radius.value_or(0.0), force);
    edge.trail = s.tool.trail;
    return edge;
  }
  const double friction = s.world.tip.friction;
  if (s.tool.kind == ToolKind::roller)
    return roller_line(foam_of(s.tool, friction, force), s.tool.trail, force);
  return pad_of(s.tool, friction, force);
}

std::optional<CutterSettings> cutter_of(const ToolSettings& tool) {
  if (tool.kind != ToolKind::engraver) return std::nullopt;
  CutterSettings cutter;
  cutter.half_angle = tool.half_angle_deg * std::numbers::pi / 180.0;
  return cutter;
}

std::vector<double> depths_of(const ToolSettings& tool) {
  constexpr double kShallow = 0.25, kLeast = 0.05e-3;  // less force leaves the surface too often
  const double first = tool.depth / tool.passes;
  std::vector<double> depths{std::max(kShallow * first, std::min(kLeast, 0.5 * first))};
  for (int i = 1; i <= tool.passes; ++i) depths.push_back(first * i);
  return depths;
}

}  // namespace impedraw
