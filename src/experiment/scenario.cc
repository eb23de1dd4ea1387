#include "impedraw/experiment/scenario.h"

#include <cmath>
#include <numbers>

namespace impedraw {

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
  f.field(
       Limits::spacing, s.spacing_mm,
       "Distance, on the canvas, between the lines that stand for a fill; 0: fills are not "
       "hatched. White is never hatched. On slopes it holds with mapping: wrap; projected, lines "
       "lie up to 1 / cos(slope) as far apart.")
      .for_users();
  f.field(Limits::angle, s.angle_deg,
          "Angle of the lines to the page's X axis, counter-clockwise.");
  f.field("cross", s.cross, "Adds a second set of lines at right angles.");
  f.field("outline", s.outline, "Draws the outlines of areas that are filled but not stroked.");
}

void describe(Fields& f, WrapSettings& s) {
  using Limits = WrapSettings::Limits;
  f.field(Limits::spacing, s.spacing,
          "Spacing of the grid that samples the surface, in the drawing plane.");
  f.field(Limits::margin, s.margin,
          "Margin of the flattened patch around the drawing; at least two spacings.");
  f.field(Limits::tolerance, s.tolerance,
          "Largest distance of a wrapped line from its polyline, in the drawing plane.");
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
  f.field("join_gap", s.join_gap_mm, {0.0, 100.0}, "mm",
          "Largest gap on the page between ends of strokes that are joined; 0: none are joined.");
  f.field("dashes", s.dashes, "Draws dashed lines of an SVG as dashes.");
  f.field("hatch", s.hatch, "Hatching of an SVG's filled areas.");
  f.field("simplify", s.simplify_mm, {0.0, 100.0}, "mm",
          "Largest distance, on the page, by which a stroke may change when points are dropped; 0: "
          "every point is kept.");
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

void describe(Fields& f, PreflightSettings& s) {
  using Limits = PreflightSettings::Limits;
  f.field("arm", s.arm,
          "Checks the arm's reach, joints, torques and collisions; off: only the surface is "
          "checked.");
  f.field(Limits::step, s.step, "Distance between the postures that are checked along a stroke.");
  f.constant(Limits::edge_tolerance, s.edge_tolerance);
  f.field(Limits::edge_margin, s.edge_margin,
          "Distance kept from edges and holes of the surface, along the stroke.");
  f.field(Limits::shortest, s.shortest,
          "Length below which the remainder of a stroke is not drawn.");
  f.field(Limits::least_speed, s.least_speed,
          "Mean speed of the drawing, but at most half of path.draw_speed. What the surface or the "
          "joints slow down too far for it is not drawn; 0: all is drawn.");
  f.field(Limits::roughest, s.roughest,
          "RMS height that the cameras do not resolve, beyond which a place is not drawn on: ink "
          "would lie over 0.5 mm off the line. 8e-4: only steps are kept off.");
  f.field(Limits::max_slope, s.max_slope_deg,
          "Largest angle between the surface normal and the drawing axis.");
  f.constant(Limits::fold_height, s.fold_height);
  f.field(Limits::joint_margin, s.joint_margin, "Margin that each joint keeps from its limits.");
  f.constant(Limits::max_joint_step, s.max_joint_step);
  f.field(Limits::clearance, s.clearance,
          "Distance that arm and pen keep from canvas and table; the pen's grows from zero at the "
          "tip.");
  f.field(Limits::table_z, s.table_z, "Height of a table; null: there is none.");
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
          "Not sim: time from a state until the torque that answers it acts; control.loop_delay "
          "is then at least one step longer.");
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
  f.field("joint_stiffness", s.joint_stiffness, JointSpringSettings::Limits::stiffness.range,
          "Nm/rad",
          "Stiffness of the joints' gears and torque sensors: one for all joints or one for each; "
          "empty: rigid. The set-up rehearses with it what observer the arm bears.")
      .or_one();
  f.field("torque_bandwidth", s.torque_bandwidth, JointSpringSettings::Limits::loop_bandwidth.range,
          "rad/s", "Bandwidth of the arm's own torque loop; 0: none.");
  f.field("posture_seed", s.posture_seed, {-3.2, 3.2}, "rad",
          "Joint angles from which the inverse kinematics starts, one per joint; empty: those of "
          "the iiwa for seven joints, else found by a search.");
  f.field("q_0", s.q_0, {-3.2, 3.2}, "rad",
          "Rest posture of the null space, one angle per joint; empty: the posture over the middle "
          "of the drawing.");
  f.field("start", s.start_p_WE, {-2.0, 2.0}, "m",
          "Position of the pen tip during the snapshot and at the start.");
}

void describe(Fields& f, FenceSettings& s) {
  f.field("low", s.low, {-2.0, 2.0}, "m", "Lowest coordinates that the tip may have.");
  f.field("high", s.high, {-2.0, 2.0}, "m", "Highest coordinates that the tip may have.");
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

void describe(Fields& f, TouchSettings& s) {
  using Limits = TouchSettings::Limits;
  f.field(Limits::slope, s.slope,
          "Slope of the surface that is thought likely before the first touch, a standard "
          "deviation.");
  f.field(Limits::curvature, s.curvature, "Curvature of the surface, a standard deviation.");
  f.constant(Limits::curvature_length, s.curvature_length);
  f.field(Limits::position_noise, s.position_noise, "Noise of a touched point's height.");
  f.field(Limits::force_noise, s.force_noise, "Noise of the slope that a measured force tells.");
  f.field(Limits::spacing, s.spacing, "Distance between the touched points that are used.");
  f.constant(Limits::slip_speed, s.slip_speed);
  f.field(Limits::turn_rate, s.turn_rate, "Largest angular speed of the learned normal.");
  f.field(Limits::search, s.search,
          "Depth beneath a surface that has been touched at which it has ended.");
  f.constant(Limits::settle_time, s.settle_time);
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

void describe(Fields& f, PathSettings& s) {
  using Limits = PathSettings::Limits;
  f.field(Limits::start_hold, s.start_hold, "Time at rest before the first motion.");
  f.field(Limits::hover_height, s.hover_height,
          "Height above the first point of a stroke at which the approach begins.");
  f.field(Limits::approach_speed, s.approach_speed, "Speed of the approach to the first point.");
  f.field(Limits::settle_time, s.settle_time, "Time at the first point before drawing.");
  f.field(Limits::draw_speed, s.draw_speed, "Speed along a stroke, on the surface.").for_users();
  f.field(Limits::draw_acceleration, s.draw_acceleration,
          "Largest acceleration of the desired tip along a stroke.");
  f.field(Limits::end_hold, s.end_hold, "Time at the last point before the lift.");
  f.field(Limits::dot_time, s.dot_time, "Time for which a dot is held.");
  f.field(Limits::travel_speed, s.travel_speed, "Speed between strokes.");
  f.field(Limits::travel_acceleration, s.travel_acceleration,
          "Largest acceleration between strokes.");
  f.field(Limits::turn_speed, s.turn_speed, "Angular speed of the pen axis between strokes.");
  f.field(Limits::turn_acceleration, s.turn_acceleration,
          "Angular acceleration of the pen axis between strokes.");
  f.field(Limits::safe_height, s.safe_height,
          "Height of travel above the highest point of the drawing.");
  f.field(Limits::smoothing_time, s.smoothing_time, "Time over which an acceleration builds up.");
  f.field(Limits::corner_angle, s.corner_angle_deg,
          "Turn of a stroke above which it has a corner, where the pen stops.");
  f.field(Limits::normal_smoothing, s.normal_smoothing,
          "Length over which the normals along a stroke are averaged.");
  f.field(Limits::normal_acceleration, s.normal_acceleration,
          "Largest acceleration across the surface, which its curvature makes: a rough surface is "
          "drawn on slower.");
  f.field(
      Limits::force_rate, s.force_rate,
      "Fastest change of the force where lines swell, at draw_speed. Where a width jumps, the line "
      "is lighter beside the jump.");
  f.field(
      Limits::normal_speed, s.normal_speed,
      "Largest speed across the surface that roughness finer than the cameras resolve may cause.");
  f.field(Limits::joint_speed_share, s.joint_speed_share,
          "Share of the arm's joint speed limits that a stroke may use.");
  f.field(Limits::joint_acceleration, s.joint_acceleration,
          "Largest acceleration of a joint along a stroke.");
  f.field(Limits::joint_torque_share, s.joint_torque_share,
          "Share of the torque that the controller may use (control.torque_share) for holding, "
          "pressing and motion along a stroke.");
  f.field(Limits::tilt_allowance, s.tilt_allowance_deg,
          "Largest angle by which the pen's axis may leave the surface normal where it would "
          "otherwise turn faster than tilt_speed or tilt_acceleration.");
  f.field(Limits::tilt_speed, s.tilt_speed,
          "Largest angular speed of the pen's axis along a stroke.");
  f.field(Limits::tilt_acceleration, s.tilt_acceleration,
          "Largest angular acceleration of the pen's axis along a stroke.");
  f.field(Limits::tolerance, s.tolerance, "Largest distance of the desired line from the artwork.");
  f.field(Limits::rounding, s.rounding,
          "The same beside a vertex where the artwork turns by more than 5°, as letters made of "
          "straight lines do; at most a fortieth of the shorter line there.");
}

void describe(Fields& f, GivenPen& s) {
  using Limits = GivenPen::Limits;
  f.field(Limits::width, s.width, "Line width at the nominal force.").for_users();
  f.field(Limits::width_per_newton, s.width_per_newton,
          "Change of the line width with the force; 0: constant width.");
  f.field(Limits::nominal_force, s.nominal_force, "Force at which the line has its nominal width.");
  f.field(Limits::least_force, s.least_force,
          "Least force of lines whose width or force is given: by an SVG's stroke-width, where the "
          "width changes with the force, or by a stroke file's column.");
  f.field(Limits::most_force, s.most_force, "Their greatest force.");
  f.field("check", s.check,
          "After a change to another of pens, touches a known spot and finds the tip's length. "
          "Needs a measured wrench.");
  f.field(Limits::spot, s.spot,
          "That spot, in the world; null: where the drawing begins, as the first pen feels it.");
  f.field(Limits::place, s.place,
          "Where the tip waits while a pen is changed, in the world; null: where the arm starts.");
}

void describe(Fields& f, LayerPenSettings& s) {
  using Limits = LayerPenSettings::Limits;
  f.field("layer", s.layer, "Number or name of the layer, as for drawing.layer.");
  f.field("colour", s.colour,
          "Colour of its ink, a name or #rrggbb; empty: that of the layer's first line.");
  f.field("force", s.force, ImpedanceSettings::Limits::normal_force.range, "N",
          "Force of lines without a width of their own; null: control.normal_force.");
  f.field("speed", s.speed, PathSettings::Limits::draw_speed.range, "m/s",
          "Speed of this pen; null: path.draw_speed.");
  f.field(Limits::width, s.width, "Line width at the nominal force; null: that of pen.");
  f.field(Limits::width_per_newton, s.width_per_newton,
          "Change of the line width with the force; null: that of pen.");
  f.field(Limits::nominal_force, s.nominal_force,
          "Force at which the line has its nominal width; null: that of pen.");
  f.field(Limits::longer, s.longer,
          "Its tip beyond that of arm.urdf, along the pen, as far as is known; null: 0.");
  f.field(Limits::radius, s.radius,
          "Radius of its tip; null: control.tip.radius, in the simulated world world.tip.radius.");
}

void describe(Fields& f, ToolSettings& s) {
  using Limits = ToolSettings::Limits;
  f.choice("kind", s.kind, {"pen", "pad", "engraver"},
           "What touches the canvas. pen: the ball of world.tip. pad: a rigid disc with a layer of "
           "foam. engraver: a turning cone that cuts grooves.");
  f.field(Limits::radius, s.radius, "Radius of the pad.");
  f.field(Limits::foam_thickness, s.foam_thickness, "Thickness of the pad's foam.");
  f.field(Limits::foam_stiffness, s.foam_stiffness, "Pressure of the foam per compression.");
  f.field(Limits::foam_damping, s.foam_damping, "Pressure of the foam per rate of compression.");
  f.field(Limits::depth, s.depth, "Depth of the engraver's groove below the surface.");
  f.field(Limits::half_angle, s.half_angle_deg, "Half of the angle of the engraver's cone.");
  f.field(Limits::passes, s.passes,
          "Cuts to that depth, in equal steps, after a shallow one that finds the surface.");
  f.field(Limits::hardness, s.hardness,
          "True cutting forces of the simulated material over the believed ones.");
}

void describe(Fields& f, CoverSettings& s) {
  using Limits = CoverSettings::Limits;
  f.field("region", s.region,
          "SVG whose filled areas are covered, placed as drawing.placement says; empty: all that "
          "the cameras see and the arm reaches.");
  f.field(Limits::overlap, s.overlap,
          "Overlap of neighbouring lines, as a share of the footprint's width. 0.55 and "
          "0.69 treat most evenly: there the first harmonic of a disc's dose vanishes.");
  f.field(Limits::direction, s.direction_deg,
          "Direction of the lines in the drawing plane, counter-clockwise from its x axis.");
  f.field(Limits::margin, s.margin, "Distance that the footprint keeps from edges and holes.");
  f.field(Limits::passes, s.passes, "How often the area is gone over.");
}

void describe(Fields& f, LogSettings& s) {
  f.choice("rate", s.rate, {"reduced", "full"},
           "full: everything of every control step; reduced: a sixth of its size, the same "
           "metrics.json, and rows at 62.5 Hz and at the extremes of the force");
}

// Elsewhere: describe_perception.cc, describe_control.cc, describe_world.cc.
void describe(Fields& f, PerceptionSettings& s);
void describe(Fields& f, ControlSettings& s);
void describe(Fields& f, WorldSettings& s);
void describe(Fields& f, WrenchSensorSettings& s);
void describe(Fields& f, PushSettings& s);
void describe(Fields& f, FaultSettings& s);

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

std::optional<PadSettings> pad_of(const ToolSettings& tool, double friction, double force) {
  if (tool.kind != ToolKind::pad) return std::nullopt;
  PadSettings pad{
      tool.radius, tool.foam_thickness, tool.foam_stiffness, tool.foam_damping, friction, 0.0};
  pad.rest = force / (pad.stiffness * pad.area());
  return pad;
}

std::optional<CutterSettings> cutter_of(const ToolSettings& tool) {
  if (tool.kind != ToolKind::engraver) return std::nullopt;
  CutterSettings cutter;
  cutter.half_angle = tool.half_angle_deg * std::numbers::pi / 180.0;
  return cutter;
}

std::vector<double> depths_of(const ToolSettings& tool) {
  constexpr double kShallow = 0.25;
  std::vector<double> depths{kShallow * tool.depth};
  for (int i = 1; i <= tool.passes; ++i)
    depths.push_back(tool.depth * (kShallow + (1.0 - kShallow) * i / tool.passes));
  return depths;
}

}  // namespace impedraw
