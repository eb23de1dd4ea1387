#include "impedraw/experiment/scenario.h"

#include <cmath>
#include <numbers>

namespace impedraw {

namespace {
constexpr double kReach = 2.0;  // [m], generous bounds of any coordinate
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
  f.field("centre", s.centre_m, Limits::centre, "m",
          "Where the middle of the drawing goes in the drawing plane (x, y).");
  f.field("scale", s.scale, Limits::size, "",
          "Millimetres on the canvas per millimetre on the page; null: set by one of the sizes.");
  f.field("width", s.width_mm, Limits::size, "mm",
          "Size of the drawing across the page; null: set by another size.");
  f.field("height", s.height_mm, Limits::size, "mm",
          "Size of the drawing down the page; null: set by another size.");
  f.field("fit_width", s.fit_width_m, Limits::fit, "m",
          "Width, along world y, of a rectangle that the drawing is scaled to fill; null: no bound "
          "that way.");
  f.field(
      "fit_height", s.fit_height_m, Limits::fit, "m",
      "Height, along world x, of a rectangle that the drawing is scaled to fill; null: no bound "
      "that way.");
  f.field("margin", s.margin_mm, Limits::margin, "mm",
          "Space left free on each side of the rectangle.");
  f.field("fit_page", s.fit_page,
          "Fits the whole page into the rectangle instead of the bounding box of the strokes.");
  f.field(
      "fit_radius", s.fit_radius_m, Limits::fit, "m",
      "Radius of the circle on which the farthest stroke point lies if no other size is given.");
  f.field("about_page_origin", s.about_page_origin,
          "Puts the page's (0, 0) at the centre instead of the middle of the strokes.");
  f.field("rotate", s.rotate_deg, Limits::rotate, "deg",
          "Rotation of the drawing, counter-clockwise as seen from above.");
  f.field("mirror", s.mirror, "Mirrors the drawing left to right.");
}

void describe(Fields& f, TextSettings& s) {
  using Limits = TextSettings::Limits;
  f.field("text", s.text,
          "Text to write in single strokes; \\n starts a new line; empty: the file or the shape is "
          "drawn.");
  f.field("font", s.font,
          "Hershey font: futural, rowmans, scripts, gothiceng, ... (/usr/share/hershey-fonts).");
  f.field("size", s.size_mm, Limits::size, "mm",
          "Height of the capitals, on the canvas if the placement gives no size; null: the text is "
          "fitted as a file is.");
  f.choice("align", s.align,
           {{"left", TextAlign::left}, {"centre", TextAlign::centre}, {"right", TextAlign::right}},
           "Alignment of the lines.");
  f.field("line_spacing", s.line_spacing, Limits::line_spacing, "",
          "Distance between baselines, as a multiple of the capitals' height.");
}

void describe(Fields& f, HatchSettings& s) {
  using Limits = HatchSettings::Limits;
  f.field("spacing", s.spacing_mm, Limits::spacing, "mm",
          "Distance, on the canvas, between the lines that stand for a fill; 0: fills are not "
          "hatched. White is never hatched.");
  f.field("angle", s.angle_deg, Limits::angle, "deg",
          "Angle of the lines to the page's X axis, counter-clockwise.");
  f.field("cross", s.cross, "Adds a second set of lines at right angles.");
  f.field("outline", s.outline, "Draws the outlines of areas that are filled but not stroked.");
}

void describe(Fields& f, WrapSettings& s) {
  using Limits = WrapSettings::Limits;
  f.field("spacing", s.spacing, Limits::spacing, "m",
          "Spacing of the grid that samples the surface, in the drawing plane.");
  f.field("margin", s.margin, Limits::margin, "m",
          "Margin of the flattened patch around the drawing; at least two spacings.");
  f.field("tolerance", s.tolerance, Limits::tolerance, "m",
          "Largest distance of a wrapped line from its polyline, in the drawing plane.");
}

void describe(Fields& f, DrawingSettings& s) {
  f.field("shape", s.shape,
          "Built-in drawing: sine, M, sine10 or circle. It is used if svg and text are empty.");
  f.field("svg", s.svg,
          "File to draw: .svg, or strokes as .txt, .strokes or .csv; empty: the shape is drawn.");
  f.field("text", s.text, "Text that is written instead of a file or shape.");
  f.choice("unit", s.unit,
           {{"file", PageUnit::file},
            {"mm", PageUnit::mm},
            {"cm", PageUnit::cm},
            {"in", PageUnit::in},
            {"m", PageUnit::m},
            {"px", PageUnit::px}},
           "Unit of the numbers in .txt, .strokes and .csv files; file: millimetres, or fractions "
           "of the page if all numbers lie between 0 and 1.");
  f.field("join_gap", s.join_gap_mm, Range{0.0, 100.0}, "mm",
          "Largest gap on the page between ends of strokes that are joined; 0: none are joined.");
  f.field("dashes", s.dashes, "Draws dashed lines of an SVG as dashes.");
  f.field("hatch", s.hatch, "Hatching of an SVG's filled areas.");
  f.field("simplify", s.simplify_mm, Range{0.0, 100.0}, "mm",
          "Largest distance, on the page, by which a stroke may change when points are dropped; 0: "
          "every point is kept.");
  f.field("keep_order", s.keep_order,
          "Keeps the order of the strokes in the file instead of shortening the travel between "
          "them.");
  f.field(
      "tilt", s.tilt_deg, Range{-180.0, 180.0}, "deg",
      "Roll, pitch and yaw of the drawing plane about the world's origin; [0, -90, 0] is a wall "
      "that faces the arm.");
  f.choice("mapping", s.mapping, {{"project", Mapping::project}, {"wrap", Mapping::wrap}},
           "How the page reaches the surface: projected along the drawing axis, or wrapped like a "
           "sheet, which preserves lengths.");
  f.field("wrap", s.wrap, "How the surface is flattened for mapping: wrap.");
  f.field("skip_unreachable", s.skip_unreachable,
          "Leaves out and reports what fails the pre-flight; otherwise nothing is drawn.");
  f.field("redraw", s.redraw,
          "Draws the parts that got no ink, judged by contact and force, once more at the end.");
  f.field("placement", s.placement,
          "Placement of the page on the canvas. A built-in shape has scale 1 unless a size is "
          "given.");
}

void describe(Fields& f, PreflightSettings& s) {
  using Limits = PreflightSettings::Limits;
  f.field("arm", s.arm,
          "Checks the arm's reach, joints, torques and collisions; off: only the surface is "
          "checked.");
  f.field("step", s.step, Limits::step, "m",
          "Distance between the postures that are checked along a stroke.");
  f.field("edge_tolerance", s.edge_tolerance, Limits::edge_tolerance, "m",
          "Accuracy of the ends of a part that cannot be drawn.");
  f.field("edge_margin", s.edge_margin, Limits::edge_margin, "m",
          "Distance kept from edges and holes of the surface, along the stroke.");
  f.field("shortest", s.shortest, Limits::shortest, "m",
          "Length below which the remainder of a stroke is not drawn.");
  f.field("max_slope", s.max_slope_deg, Limits::max_slope, "deg",
          "Largest angle between the surface normal and the drawing axis.");
  f.field("fold_height", s.fold_height, Limits::fold_height, "m",
          "Height of a step in the surface above which a stroke is cut.");
  f.field("joint_margin", s.joint_margin, Limits::joint_margin, "rad",
          "Margin that each joint keeps from its limits.");
  f.field("max_joint_step", s.max_joint_step, Limits::max_joint_step, "rad",
          "Largest motion of a joint from one checked posture to the next.");
  f.field("clearance", s.clearance, Limits::clearance, "m",
          "Distance that arm and pen keep from canvas and table; the pen's grows from zero at the "
          "tip.");
  f.field("table_z", s.table_z, Limits::table_z, "m", "Height of a table; null: there is none.");
}

void describe(Fields& f, ArmSettings& s) {
  f.field("urdf", s.urdf, "URDF of the arm with its pen; empty: the iiwa 14 in models/.");
  f.field("posture_seed", s.posture_seed, Range{-3.2, 3.2}, "rad",
          "Joint angles from which the inverse kinematics starts.");
  f.field("q_0", s.q_0, Range{-3.2, 3.2}, "rad",
          "Rest posture of the null space; empty: the posture over the middle of the drawing.");
  f.field("start", s.start_p_WE, Range{-kReach, kReach}, "m",
          "Position of the pen tip during the snapshot and at the start.");
}

void describe(Fields& f, CameraSettings& s) {
  f.field("position", s.p_WC, Range{-10.0, 10.0}, "m", "Position of the pinhole.");
  f.field("target", s.target_W, Range{-10.0, 10.0}, "m", "Point in the middle of the image.");
  f.field("width", s.width, DepthCamera::Limits::size, "px", "Width of the image.");
  f.field("height", s.height, DepthCamera::Limits::size, "px", "Height of the image.");
  f.field("fov_y", s.fov_y_deg, DepthCamera::Limits::fov_y, "deg", "Vertical field of view.");
}

void describe(Fields& f, DepthNoise& s) {
  f.field("sigma_at_1m", s.sigma_at_1m, DepthNoise::Limits::at_1m, "m",
          "Standard deviation of the depth at 1 m; it grows with depth². A real camera has 0.001.");
  f.field("quantum_at_1m", s.quantum_at_1m, DepthNoise::Limits::at_1m, "m",
          "Resolution of the depth at 1 m; it grows with depth². 0: continuous.");
}

void describe(Fields& f, NormalSettings& s) {
  using Limits = NormalSettings::Limits;
  f.choice("mode", s.mode,
           {{"fresh", NormalMode::fresh}, {"interpolated", NormalMode::interpolated}},
           "Whether the normal is fitted anew at each step or interpolated between normals fitted "
           "once.");
  f.field("k", s.k, Limits::k, "", "Number of nearest neighbours, equation (18).");
  f.field("max_radius", s.max_radius, Limits::max_radius, "m",
          "Largest distance of a neighbour from the query.");
  f.choice("weighting", s.weighting,
           {{"uniform", NeighbourWeighting::uniform}, {"smooth", NeighbourWeighting::smooth}},
           "Weights of the neighbours: all equal, as in the paper, or fading out with distance.");
  f.choice("fit", s.fit, {{"plane", SurfaceFit::plane}, {"quadric", SurfaceFit::quadric}},
           "Surface fitted through the neighbours: a plane, as in the paper, or a quadric.");
  f.field("max_one_sidedness", s.max_one_sidedness, Limits::max_one_sidedness, "",
          "One-sidedness of the neighbours above which the tip is taken to be off the cloud's "
          "edge.");
}

void describe(Fields& f, PerceptionSettings& s) {
  using Limits = CloudSettings::Limits;
  f.field("enabled", s.enabled, "Uses the depth cameras; off: blind stiffness control.");
  f.field("cameras", s.cameras, "Depth cameras, which take one snapshot before drawing.");
  f.field("noise", s.noise, "Noise of the depth.");
  f.field("voxel", s.voxel, Limits::voxel, "m",
          "Side of the cubes in which points are averaged; 0: every point is kept.");
  f.field("adapt", s.adapt,
          "Uses smaller patches, down to a quarter, where the surface is rougher than noise "
          "explains.");
  f.field("self_padding", s.self_padding, Limits::self_padding, "m",
          "Distance from the arm below which points are removed.");
  f.field("region_lower", s.region_lower, Range{-10.0, 10.0}, "m",
          "Lower corner of the region of interest.");
  f.field("region_upper", s.region_upper, Range{-10.0, 10.0}, "m",
          "Upper corner of the region of interest.");
  f.field("normals", s.normals, "Surface normals from the cloud, equations (18) and (19).");
}

void describe(Fields& f, BlindSettings& s) {
  f.choice("height", s.height, {{"canvas", BlindHeight::canvas}, {"plane", BlindHeight::plane}},
           "Height of the set-point without perception: the true canvas's, or one plane below it.");
  f.field("plane_z", s.plane_z, Range{-kReach, kReach}, "m", "Height of that plane.");
}

void describe(Fields& f, PathSettings& s) {
  using Limits = PathSettings::Limits;
  f.field("start_hold", s.start_hold, Limits::start_hold, "s",
          "Time at rest before the first motion.");
  f.field("hover_height", s.hover_height, Limits::hover_height, "m",
          "Height above the first point of a stroke at which the approach begins.");
  f.field("approach_speed", s.approach_speed, Limits::approach_speed, "m/s",
          "Speed of the approach to the first point.");
  f.field("settle_time", s.settle_time, Limits::settle_time, "s",
          "Time at the first point before drawing.");
  f.field("draw_speed", s.draw_speed, Limits::draw_speed, "m/s",
          "Speed along a stroke, on the surface.");
  f.field("draw_acceleration", s.draw_acceleration, Limits::draw_acceleration, "m/s²",
          "Largest acceleration of the desired tip along a stroke.");
  f.field("end_hold", s.end_hold, Limits::end_hold, "s", "Time at the last point before the lift.");
  f.field("dot_time", s.dot_time, Limits::dot_time, "s", "Time for which a dot is held.");
  f.field("travel_speed", s.travel_speed, Limits::travel_speed, "m/s", "Speed between strokes.");
  f.field("travel_acceleration", s.travel_acceleration, Limits::travel_acceleration, "m/s²",
          "Largest acceleration between strokes.");
  f.field("turn_speed", s.turn_speed, Limits::turn_speed, "rad/s",
          "Angular speed of the pen axis between strokes.");
  f.field("turn_acceleration", s.turn_acceleration, Limits::turn_acceleration, "rad/s²",
          "Angular acceleration of the pen axis between strokes.");
  f.field("safe_height", s.safe_height, Limits::safe_height, "m",
          "Height of travel above the highest point of the drawing.");
  f.field("smoothing_time", s.smoothing_time, Limits::smoothing_time, "s",
          "Time over which an acceleration builds up.");
  f.field("corner_angle", s.corner_angle_deg, Limits::corner_angle, "deg",
          "Turn of a stroke above which it has a corner, where the pen stops.");
  f.field("normal_smoothing", s.normal_smoothing, Limits::normal_smoothing, "m",
          "Length over which the normals along a stroke are averaged.");
  f.field("normal_acceleration", s.normal_acceleration, Limits::normal_acceleration, "m/s²",
          "Largest acceleration across the surface, which its curvature makes: a rough surface is "
          "drawn on slower.");
  f.field("joint_speed_share", s.joint_speed_share, Limits::joint_speed_share, "",
          "Share of the arm's joint speed limits that a stroke may use.");
  f.field("tilt_allowance", s.tilt_allowance_deg, Limits::tilt_allowance, "deg",
          "Largest angle by which the pen's axis may leave the surface normal where it would "
          "otherwise turn faster than tilt_speed or tilt_acceleration.");
  f.field("tilt_speed", s.tilt_speed, Limits::tilt_speed, "rad/s",
          "Largest angular speed of the pen's axis along a stroke.");
  f.field("tilt_acceleration", s.tilt_acceleration, Limits::tilt_acceleration, "rad/s²",
          "Largest angular acceleration of the pen's axis along a stroke.");
  f.field("tolerance", s.tolerance, Limits::tolerance, "m",
          "Largest distance of the desired line from the artwork.");
}

namespace {

// "Stiffness K along both tangents." and "... along the normal.", or about them.
void describe_axial(Fields& f, const std::string& name, AxialGain& gain, const std::string& unit,
                    Range range, const std::string& help) {
  f.field(name + "_tangent", gain.tangent, range, unit, help + " both tangents of the surface.");
  f.field(name + "_normal", gain.normal, range, unit, help + " the surface normal.");
}

}  // namespace

void describe(Fields& f, ContactSettings& s) {
  f.field("enter_distance", s.enter_distance, Range{0.0, 0.05}, "m",
          "Distance to the estimated surface below which contact can begin without a measured "
          "wrench.");
  f.field(
      "search_distance", s.search_distance, Range{0.0, 0.05}, "m",
      "Distance to the estimated surface below which contact can begin with a measured wrench.");
  f.field("leave_distance", s.leave_distance, Range::positive_to(0.1), "m",
          "Distance to the estimated surface above which contact is lost.");
  f.field("touch_force", s.touch_force, Range{0.0, 50.0}, "N",
          "Measured normal force above which the pen touches.");
  f.field("touch_gap", s.touch_gap, Range{1e-5, 0.02}, "m",
          "Lag of the tip behind the approach above which the pen touches, without a measured "
          "wrench.");
  f.field("loss_force", s.loss_force, Range{0.0, 50.0}, "N",
          "Measured normal force below which contact may be lost.");
  f.field("loss_time", s.loss_time, Range{0.0, 5.0}, "s",
          "Time below loss_force after which contact is lost.");
  f.field("lost_surface_time", s.lost_surface_time, Range{0.0, 5.0}, "s",
          "Time for which the last normal is trusted when perception has no surface.");
}

void describe(Fields& f, ObserverSettings& s) {
  f.field("enabled", s.enabled, "Uses the observer. It needs a measured wrench.");
  f.field("bandwidth", s.bandwidth, Range{1.0, 900.0}, "rad/s",
          "Bandwidth of the observer's low-pass filter.");
  f.field("limit", s.limit, Range{0.0, 1000.0}, "Nm",
          "Largest torque that the observer compensates on a joint.");
}

void describe(Fields& f, ForceIntegralSettings& s) {
  f.field("enabled", s.enabled, "Uses the integral. It needs a measured wrench.");
  f.field("rate", s.rate, Range{0.01, 50.0}, "1/s", "Integral gain.");
  f.field("limit", s.limit, Range{0.0, 50.0}, "N",
          "Largest force that the integral adds to the normal force.");
}

void describe(Fields& f, Tool& s) {
  f.field("mass", s.mass, Range{0.0, 20.0}, "kg",
          "Mass of the tool. ./impedraw calibrate-tool identifies it.");
  f.field("centre", s.p_SC, Range{-1.0, 1.0}, "m", "Centre of mass in the sensor's frame.");
}

void describe(Fields& f, SensingSettings& s) {
  f.field("tool", s.tool, "Model of the tool below the sensor.");
  f.field("remove_weight", s.removal.weight, "Removes the tool's weight from the reading.");
  f.field("remove_inertia", s.removal.inertia,
          "Removes the wrench that accelerates the tool from the reading.");
  f.field("remove_coriolis", s.removal.coriolis,
          "Removes the tool's centrifugal and gyroscopic wrench from the reading.");
  f.field("tip_distance", s.tip_distance, Range{0.0, 2.0}, "m",
          "Modelled distance of the tip from the sensor, along the pen.");
  f.field("sensor_delay", s.sensor_delay, Range{0.0, 0.03}, "s",
          "Modelled delay of the sensor; null: its true delay.");
  f.field("filter_bandwidth", s.filter_bandwidth, Range{0.0, 1900.0}, "rad/s",
          "Bandwidth of the wrench's low-pass filter; 0: no filter.");
  f.field("tare_time", s.tare_time, Range{0.01, 60.0}, "s",
          "Time at rest in the air, before the first stroke, over which the sensor is tared.");
}

void describe(Fields& f, ControlSettings& s) {
  f.choice("inertia", s.inertia,
           {{"natural", InertiaShaping::natural},
            {"scaled", InertiaShaping::scaled},
            {"shaped", InertiaShaping::shaped}},
           "Desired inertia M_d: the arm's own, a multiple of it, or the constant one set below.");
  f.choice("wrench", s.source,
           {{"none", WrenchSource::none},
            {"ground_truth", WrenchSource::truth},
            {"sensor", WrenchSource::sensor},
            {"realistic", WrenchSource::realistic}},
           "Source of the external wrench F_ext: none, the simulator, a sensor with the faults in "
           "wrench_sensor, or one with the faults of a real sensor.");
  f.formerly("true", "ground_truth");
  f.choice("projection", s.surface.projection,
           {{"lifted", ErrorProjection::lifted}, {"paper", ErrorProjection::paper}},
           "Projection of the position error in contact, equation (13): with full stiffness on any "
           "slope, or as in the paper.");
  describe_axial(f, "stiffness", s.stiffness.linear, "N/m", Range{0.0, 20000.0},
                 "Stiffness K along");
  describe_axial(f, "rotational_stiffness", s.stiffness.angular, "Nm/rad", Range{0.0, 1000.0},
                 "Stiffness K about");
  describe_axial(f, "reference_stiffness", s.reference_stiffness.linear, "N/m", Range{0.0, 20000.0},
                 "Stiffness K' that sets the damping where K is zero, along");
  describe_axial(f, "reference_rotational_stiffness", s.reference_stiffness.angular, "Nm/rad",
                 Range{0.0, 1000.0}, "Stiffness K' that sets the damping where K is zero, about");
  describe_axial(f, "mass", s.shaped_inertia.linear, "kg", Range::positive_to(1000.0),
                 "Desired mass for inertia: shaped, along");
  describe_axial(f, "rotational_inertia", s.shaped_inertia.angular, "kg m²",
                 Range::positive_to(100.0), "Desired moment of inertia for inertia: shaped, about");
  f.field("inertia_scale", s.inertia_scale, Range{0.01, 100.0}, "",
          "Desired inertia as a multiple of the arm's own, for inertia: scaled.");
  f.field("damping_ratio", s.damping_ratio, Range{0.05, 3.0}, "", "Damping ratio of every mode.");
  f.field("normal_force", s.normal_force, Range{0.0, 50.0}, "N",
          "Normal force that the pen presses with while drawing.");
  f.formerly("push");
  f.field("switch_time", s.switch_time, Range{0.001, 5.0}, "s",
          "Time constant of the transition between contact modes.");
  f.field("approach_speed", s.approach.speed, Range{1e-4, 0.2}, "m/s",
          "Speed along the normal until the pen touches.");
  f.field("approach_overtravel", s.approach.overtravel, Range{0.0, 0.1}, "m",
          "Depth below the estimated surface at which the approach stops.");
  f.field("approach_lag", s.approach.lag, Range{1e-4, 0.05}, "m",
          "Lag of the tip above which the approach waits.");
  f.field("retreat_height", s.approach.retreat_height, Range{0.0, 0.5}, "m",
          "Height above the plan to which the pen retreats when the surface is lost.");
  f.field("normal_bandwidth", s.surface.normal_bandwidth, Range{1.0, 500.0}, "rad/s",
          "Bandwidth of the filter of the surface normal.");
  f.choice("pen_axis", s.surface.pen_axis, {{"plan", PenAxis::plan}, {"surface", PenAxis::surface}},
           "Pen's axis while drawing: along the plan's smoothed normals, or along the estimated "
           "normal at the tip. The pen pushes along the estimated normal either way.");
  f.field("tip_radius", s.tip.radius, Range{0.0, 0.05}, "m", "Modelled radius of the tip.");
  f.field("tip_stiffness", s.tip.stiffness, Range{0.0, 1e7}, "N/m",
          "Modelled stiffness of the tip along the normal; 0: rigid.");
  f.field("friction", s.friction.coefficient, Range{0.0, 3.0}, "",
          "Modelled coefficient of friction: the part of a measured wrench that tip friction can "
          "explain.");
  f.field("friction_feedforward", s.friction.feedforward, Range{0.0, 3.0}, "",
          "Modelled coefficient of friction that is compensated along a stroke without a measured "
          "wrench.");
  f.field("contact_stiffness_max", s.stability_check.contact_stiffness_max, Range{1.0, 1e7}, "N/m",
          "Stiffest contact of tip and canvas in the stability check at set-up.");
  f.field("natural_mass_max", s.stability_check.natural_mass_max, Range{0.1, 1000.0}, "kg",
          "Largest effective mass along the normal in the stability check at set-up.");
  f.field("null_stiffness", s.null_space.stiffness, Range{0.0, 500.0}, "Nm/rad",
          "Stiffness K_q of the null space, equation (15).");
  f.field("null_damping_ratio", s.null_space.damping_ratio, Range{0.0, 3.0}, "",
          "Damping ratio of the null space.");
  f.field("observer", s.observer, "Momentum observer of the torque that the arm's model misses.");
  f.field(
      "torque_delay", s.torque_delay, Range{0.0, 0.02}, "s",
      "Delay of the drives; loop_delay is then at least one step longer. null: loop_delay alone "
      "counts.");
  f.field("loop_delay", s.timing.loop_delay, Range{0.0, 0.02}, "s",
          "Greatest age of the state while a torque acts: one step and the delay of the drives.");
  f.field("force_integral", s.force_integral, "Integral of the force error along the normal.");
  f.field("sensing", s.sensing, "From the sensor's readings to the wrench at the tip.");
  f.field("torque_share", s.torque_share, Range{0.01, 1.0}, "",
          "Fraction of the arm's torque limits that may be used.");
  f.field("torque_rate", s.torque_rate, Range{1.0, 1e6}, "Nm/s",
          "Largest rate of change of a joint's torque.");
  f.field("limit_margin", s.joint_range.margin, Range{0.001, 1.0}, "rad",
          "Distance from its limit at which a joint is pushed back, in the null space.");
  f.field("limit_torque", s.joint_range.torque, Range{0.0, 300.0}, "Nm",
          "Torque that pushes a joint back at its limit.");
  f.field("tip_speed_limit", s.limits.tip_speed, Range{0.001, 5.0}, "m/s",
          "Largest tip speed that the control law may ask for.");
  f.field("turn_speed_limit", s.limits.turn_speed, Range{0.01, 50.0}, "rad/s",
          "Largest angular speed of the pen's axis that the control law may ask for.");
  f.field("max_state_age", s.timing.max_state_age, Range{0.0, 1.0}, "s",
          "Age above which a joint state is stale.");
  f.field("max_wrench_age", s.timing.max_wrench_age, Range{0.0, 1.0}, "s",
          "Age above which a wrench is stale.");
  f.field("contact", s.contact, "When contact begins and ends.");
}

void describe(Fields& f, TipMaterial& s) {
  f.field("radius", s.radius, Range{1e-5, 0.05}, "m", "Radius of the tip sphere.");
  f.field("stiffness", s.stiffness, Range{10.0, 1e7}, "N/m", "Stiffness along the normal.");
  f.field("damping", s.damping, Range{0.0, 1e5}, "N s/m", "Damping along the normal.");
  f.field("friction", s.friction, Range{0.0, 3.0}, "",
          "Coulomb friction coefficient of tip and canvas.");
}

void describe(Fields& f, ModelErrors& s) {
  f.field("mass_scale", s.mass_scale, Range{0.1, 10.0}, "",
          "True mass and inertia of every link and the pen as a multiple of the modelled ones.");
  f.field("centre_shift", s.centre_shift, Range{-0.2, 0.2}, "m",
          "Shift of every link's centre of mass.");
  f.field("viscous_friction", s.viscous_friction, Range{0.0, 100.0}, "Nm s/rad",
          "Viscous friction of every joint.");
  f.field("rotor_inertia", s.rotor_inertia, Range{0.0, 10.0}, "kg m²",
          "Rotor inertia of every joint.");
  f.field("torque_ripple", s.torque_ripple, Range{0.0, 20.0}, "Nm",
          "Amplitude of the torque ripple of every joint.");
  f.field("torque_quantum", s.torque_quantum, Range{0.0, 10.0}, "Nm",
          "Resolution of the joint torques; 0: continuous.");
  f.field("loop_delay", s.loop_delay, Range{0.0, 0.015}, "s",
          "Delay after which a commanded torque acts.");
  f.field("pen_longer", s.pen_longer, Range{-0.02, 0.02}, "m",
          "Length of the true pen beyond the modelled one.");
}

void describe(Fields& f, WrenchSensorSettings& s) {
  f.field("noise_force", s.noise_force, Range{0.0, 100.0}, "N",
          "Standard deviation of a force sample at 1 kHz.");
  f.field("noise_torque", s.noise_torque, Range{0.0, 10.0}, "Nm",
          "Standard deviation of a torque sample at 1 kHz.");
  f.field("bias_force", s.bias_force, Range{0.0, 1000.0}, "N",
          "Magnitude of the force bias. Its direction comes from the seed.");
  f.field("bias_torque", s.bias_torque, Range{0.0, 100.0}, "Nm",
          "Magnitude of the torque bias. Its direction comes from the seed.");
  f.field("drift_force", s.drift_force, Range{0.0, 100.0}, "N/min", "Drift of the force bias.");
  f.field("drift_torque", s.drift_torque, Range{0.0, 10.0}, "Nm/min", "Drift of the torque bias.");
  f.field("quantum_force", s.quantum_force, Range{0.0, 10.0}, "N",
          "Resolution of the force; 0: continuous.");
  f.field("quantum_torque", s.quantum_torque, Range{0.0, 1.0}, "Nm",
          "Resolution of the torque; 0: continuous.");
  f.field("range_force", s.range_force, Range{0.0, 1e5}, "N",
          "Force at which an axis saturates; 0: never.");
  f.field("range_torque", s.range_torque, Range{0.0, 1e4}, "Nm",
          "Torque at which an axis saturates; 0: never.");
  f.field("delay", s.delay, Range{0.0, 0.03}, "s", "Delay of the readings.");
}

void describe(Fields& f, WorldSettings& s) {
  f.field("errors", s.errors, "Differences between the true arm and its model.");
  f.field("tip", s.tip, "True properties of the pen's tip.");
  f.field("joint_friction", s.joint_friction, Range{0.0, 50.0}, "Nm",
          "Coulomb friction of every joint.");
  f.field("gravity", s.gravity, Range{0.0, 100.0}, "m/s²", "Gravity along -z.");
}

void describe(Fields& f, PenSettings& s) {
  f.field("width", s.width, Range{0.01, 20.0}, "mm", "Line width at the nominal force.");
  f.field("width_per_newton", s.width_per_newton, Range{-10.0, 10.0}, "mm/N",
          "Change of the line width with the force; 0: constant width.");
  f.field("nominal_force", s.nominal_force, Range{0.0, 100.0}, "N",
          "Force at which the line has its nominal width.");
}

void describe(Fields& f, PushSettings& s) {
  f.field("force", s.force, Range{0.0, 200.0}, "N", "Tangential force on the pen tip.");
  f.field("direction", s.direction_W, Range{-1.0, 1.0}, "",
          "Direction of the force in world axes, projected onto the canvas's tangent plane.");
  f.field("lift", s.lift, Range{-200.0, 200.0}, "N",
          "Additional force along the canvas's outward normal.");
  f.field("middle", s.middle, Range{0.0, 1.0}, "",
          "Middle of the push, as a fraction of the time from the start of the first stroke to the "
          "end of the last.");
  f.field("duration", s.duration, Range{0.0, 1000.0}, "s", "Duration of the push.");
}

void describe(Fields& f, FaultSettings& s) {
  f.choice("kind", s.kind,
           {{"nan_state", FaultKind::nan_state},
            {"stale_state", FaultKind::stale_state},
            {"nan_wrench", FaultKind::nan_wrench},
            {"stale_wrench", FaultKind::stale_wrench},
            {"no_cloud", FaultKind::no_cloud},
            {"slow_step", FaultKind::slow_step}},
           "Fault around the controller.");
  f.field("start", s.start, Range{0.0, 1.0}, "",
          "Start of the fault, as a fraction of the time from the start of the first stroke to the "
          "end of the last.");
  f.formerly("middle");
  f.field("duration", s.duration, Range{0.0, 1000.0}, "s", "Duration of the fault.");
}

void describe(Fields& f, LogSettings& s) {
  f.choice("rate", s.rate, {{"reduced", LogRate::reduced}, {"full", LogRate::full}},
           "full: everything of every control step; reduced: a sixth of its size, the same "
           "metrics.json, and rows at 62.5 Hz and at the extremes of the force");
}

void describe(Fields& f, Scenario& s) {
  f.field("name", s.name, "Name of the run, and of its folder.");
  f.field("seed", s.seed, Range{0, 1e9}, "", "Seed of all random numbers.");
  f.field("drawing", s.drawing, "What is drawn.");
  f.field("canvas", s.canvas, "The surface that is drawn on.");
  f.field("arm", s.arm, "The robot arm.");
  f.field("perception", s.perception, "How the canvas is seen.");
  f.field("blind", s.blind, "Control without perception.");
  f.field("path", s.path, "Motion of the pen tip.");
  f.field("preflight", s.preflight, "Checks before anything moves.");
  f.field("control", s.control, "The control law.");
  f.field("world", s.world, "The simulated world.");
  f.field("wrench_sensor", s.wrench_sensor,
          "Faults of the sensor between flange and pen, for control.wrench: sensor.");
  f.field("pen", s.pen, "The line that the pen leaves in the pictures.");
  f.field("log", s.log, "How much of the run the log keeps.");
  f.field("pushes", s.pushes, "Pushes on the pen, as by a hand.");
  f.field("faults", s.faults, "Faults that are injected on purpose.");
}

}  // namespace impedraw
