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
  f.field("centre", s.centre_m, Range{-kReach, kReach}, "m",
          "where the middle of the drawing goes (x, y)");
  f.field("scale", s.scale, Range::positive(), "",
          "world mm per page mm; null: by the sizes below");
  f.field("width", s.width_mm, Range::positive(), "mm",
          "size of the drawing across the page; null: by the others");
  f.field("height", s.height_mm, Range::positive(), "mm",
          "size of the drawing down the page; null: by the others");
  f.field("fit_width", s.fit_width_m, Range{0.0, kReach, true}, "m",
          "as large as fits into a rectangle so wide (along world y); null: by the others");
  f.field("fit_height", s.fit_height_m, Range{0.0, kReach, true}, "m",
          "and so high (along world x); with one of them alone the other way is free");
  f.field("margin", s.margin_mm, Range{0.0, 1e3 * kReach}, "mm",
          "left free on each side of that rectangle");
  f.field("fit_page", s.fit_page,
          "the whole page goes into that rectangle, not the box of what is drawn");
  f.field("fit_radius", s.fit_radius_m, Range{0.0, kReach, true}, "m",
          "with no size given: the farthest stroke point lies on this circle");
  f.field("about_page_origin", s.about_page_origin,
          "the page's (0, 0) goes to the centre, not the middle of the strokes");
  f.field("rotate", s.rotate_deg, Range{-360.0, 360.0}, "deg",
          "counter-clockwise, seen from above");
  f.field("mirror", s.mirror, "left to right");
}

void describe(Fields& f, TextSettings& s) {
  f.field(
      "text", s.text,
      "to be written in single strokes; \\n ends a line; empty: the file or the shape is drawn");
  f.field("font", s.font,
          "a Hershey font: futural, rowmans, scripts, gothiceng, ... (/usr/share/hershey-fonts)");
  f.field(
      "size", s.size_mm, Range{0.0, 1e4, true}, "mm",
      "height of its capitals, on the canvas if the placement has no size; null: fitted as a file");
  f.choice("align", s.align,
           {{"left", TextAlign::left}, {"centre", TextAlign::centre}, {"right", TextAlign::right}},
           "of its lines");
  f.field("line_spacing", s.line_spacing, Range{0.1, 100.0}, "",
          "from line to line, in heights of the capitals");
}

void describe(Fields& f, HatchSettings& s) {
  f.field("spacing", s.spacing_mm, Range{0.0, 1000.0}, "mm",
          "on the canvas, of the lines that stand for a fill; 0: none. White is not hatched");
  f.field("angle", s.angle_deg, Range{-360.0, 360.0}, "deg",
          "of the lines to the page's X, counter-clockwise");
  f.field("cross", s.cross, "and as many across them");
  f.field("outline", s.outline, "outlines of what is filled and not stroked are drawn, too");
}

void describe(Fields& f, WrapSettings& s) {
  f.field("spacing", s.spacing, Range{5e-4, 0.02}, "m", "of the grid in the drawing plane");
  f.field("margin", s.margin, Range{0.001, 0.5}, "m",
          "of the patch about the drawing; at least two spacings");
  f.field("tolerance", s.tolerance, Range{1e-7, 1e-2}, "m",
          "of a page line's image, in the drawing plane");
}

void describe(Fields& f, DrawingSettings& s) {
  f.field("shape", s.shape,
          "built-in drawing: sine, M, sine10, circle; used where svg and text are empty");
  f.field("svg", s.svg,
          "file to draw: .svg, or strokes as .txt, .strokes or .csv; empty: the shape");
  f.field("text", s.text, "a text to write instead");
  f.choice("unit", s.unit,
           {{"file", PageUnit::file},
            {"mm", PageUnit::mm},
            {"cm", PageUnit::cm},
            {"in", PageUnit::in},
            {"m", PageUnit::m},
            {"px", PageUnit::px}},
           "of the numbers in .txt, .strokes and .csv; file: mm, or shares of the page where all "
           "lie between 0 and 1");
  f.field("join_gap", s.join_gap_mm, Range{0.0, 100.0}, "mm",
          "strokes of a file whose ends lie so near on the page are joined; 0: none");
  f.field("dashes", s.dashes, "lines that an SVG dashes are drawn dashed");
  f.field("hatch", s.hatch, "how an SVG's fills are drawn");
  f.field("simplify", s.simplify_mm, Range{0.0, 100.0}, "mm",
          "points of a file that lie so near to the line through the rest are left out; 0: none");
  f.field("keep_order", s.keep_order,
          "strokes of a file are drawn as it lists them, not with short ways in the air");
  f.field("tilt", s.tilt_deg, Range{-180.0, 180.0}, "deg",
          "roll, pitch, yaw of the drawing plane about the world's origin; [0, -90, 0] is a wall "
          "that faces the arm");
  f.choice("mapping", s.mapping, {{"project", Mapping::project}, {"wrap", Mapping::wrap}},
           "from page to surface: straight along the plane's axis, or laid on it like a sheet, so "
           "that lengths are kept");
  f.field("wrap", s.wrap, "how the surface is laid flat");
  f.field("skip_unreachable", s.skip_unreachable,
          "what fails the pre-flight is left out and told; else nothing is drawn");
  f.field("redraw", s.redraw,
          "parts that got no ink, by contact and force, are drawn once more after the last stroke");
  f.field(
      "placement", s.placement,
      "of the page on the canvas; built-in shapes are not fitted: scale 1 unless a size is given");
}

void describe(Fields& f, PreflightSettings& s) {
  f.field("arm", s.arm,
          "off: only the surface is looked at, and the arm is taken to reach all of it");
  f.field("step", s.step, Range{1e-4, 0.1}, "m",
          "between postures that are checked along a stroke");
  f.field("edge_tolerance", s.edge_tolerance, Range{1e-6, 0.01}, "m",
          "of where a part that cannot be drawn begins and ends");
  f.field("edge_margin", s.edge_margin, Range{0.0, 0.1}, "m",
          "kept from edges and holes, along the stroke");
  f.field("shortest", s.shortest, Range{0.0, 1.0}, "m", "a shorter rest of a stroke is not drawn");
  f.field("max_slope", s.max_slope_deg, Range{0.0, 89.0, true}, "deg",
          "between the surface's normal and the drawing axis");
  f.field("fold_height", s.fold_height, Range{1e-6, 0.1}, "m",
          "a higher step of the surface cuts a stroke");
  f.field("joint_margin", s.joint_margin, Range{0.0, 1.0}, "rad", "of every joint from its limits");
  f.field("max_joint_step", s.max_joint_step, Range{0.001, 3.0}, "rad",
          "of any joint from one posture to the next");
  f.field("clearance", s.clearance, Range{0.0, 0.2}, "m",
          "of arm and pen from canvas and table; the pen's grows from none at the tip");
  f.field("table_z", s.table_z, Range{-kReach, kReach}, "m", "height of a table; null: none");
}

void describe(Fields& f, ArmSettings& s) {
  f.field("urdf", s.urdf, "arm and pen; empty: the iiwa 14 of models/");
  f.field("posture_seed", s.posture_seed, Range{-3.2, 3.2}, "rad",
          "inverse kinematics start here and stay near");
  f.field("q_0", s.q_0, Range{-3.2, 3.2}, "rad",
          "rest posture of the null space; empty: over the middle of the drawing");
  f.field("start", s.start_p_WE, Range{-kReach, kReach}, "m",
          "pen tip at the snapshot and at the start");
}

void describe(Fields& f, CameraSettings& s) {
  f.field("position", s.p_WC, Range{-10.0, 10.0}, "m", "of the pinhole");
  f.field("target", s.target_W, Range{-10.0, 10.0}, "m", "in the middle of the image");
  f.field("width", s.width, Range{1, 8192}, "px", "of the image");
  f.field("height", s.height, Range{1, 8192}, "px", "of the image");
  f.field("fov_y", s.fov_y_deg, Range{1.0, 170.0}, "deg", "vertical field of view");
}

void describe(Fields& f, DepthNoise& s) {
  f.field("sigma_at_1m", s.sigma_at_1m, Range{0.0, 0.1}, "m",
          "standard deviation at 1 m, growing as depth²; realistic: 0.001");
  f.field("quantum_at_1m", s.quantum_at_1m, Range{0.0, 0.1}, "m",
          "step of the depth at 1 m, growing as depth²");
}

void describe(Fields& f, NormalSettings& s) {
  f.choice("mode", s.mode,
           {{"fresh", NormalMode::fresh}, {"interpolated", NormalMode::interpolated}},
           "anew at every step, or from normals computed once");
  f.field("k", s.k, Range{8, kMostNeighbours}, "", "nearest neighbours (18)");
  f.field("max_radius", s.max_radius, Range{0.001, 1.0}, "m", "how far they may lie");
  f.choice("weighting", s.weighting,
           {{"uniform", NeighbourWeighting::uniform}, {"smooth", NeighbourWeighting::smooth}},
           "of the neighbours: the paper's, or fading out");
  f.choice("fit", s.fit, {{"plane", SurfaceFit::plane}, {"quadric", SurfaceFit::quadric}},
           "through them: the paper's, or with its curvature");
  f.field("max_one_sidedness", s.max_one_sidedness, Range{0.0, 1.0, true}, "",
          "beyond it the tip is off the cloud's edge");
}

void describe(Fields& f, PerceptionSettings& s) {
  f.field("enabled", s.enabled, "off: blind stiffness control");
  f.field("cameras", s.cameras, "depth cameras; one snapshot before drawing");
  f.field("noise", s.noise, "of the depth");
  f.field("voxel", s.voxel, Range{0.0, 0.1}, "m", "cube in which points are averaged; 0: none");
  f.field("self_padding", s.self_padding, Range{0.0, 0.2}, "m",
          "points nearer to the arm go with it");
  f.field("region_lower", s.region_lower, Range{-10.0, 10.0}, "m",
          "corner of the box that is looked at");
  f.field("region_upper", s.region_upper, Range{-10.0, 10.0}, "m", "the opposite corner");
  f.field("normals", s.normals, "of the cloud (18)-(19)");
}

void describe(Fields& f, BlindSettings& s) {
  f.choice("height", s.height, {{"canvas", BlindHeight::canvas}, {"plane", BlindHeight::plane}},
           "of the set-point without perception: the target's, or one plane beneath it all");
  f.field("plane_z", s.plane_z, Range{-kReach, kReach}, "m", "of that plane");
}

void describe(Fields& f, PathSettings& s) {
  f.field("start_hold", s.start_hold, Range{0.0, 60.0}, "s", "at rest before anything moves");
  f.field("hover_height", s.hover_height, Range{0.0, 0.1}, "m",
          "above the first point: the approach begins there");
  f.field("approach_speed", s.approach_speed, Range{1e-4, 0.2}, "m/s", "down to the first point");
  f.field("settle_time", s.settle_time, Range{0.0, 10.0}, "s", "at the first point before drawing");
  f.field("draw_speed", s.draw_speed, Range{1e-4, 1.0}, "m/s", "along the stroke, on the surface");
  f.field("draw_acceleration", s.draw_acceleration, Range{0.01, 20.0}, "m/s²",
          "of the desired tip along a stroke");
  f.field("end_hold", s.end_hold, Range{0.0, 10.0}, "s", "at the last point before the lift");
  f.field("dot_time", s.dot_time, Range{0.0, 10.0}, "s", "that a dot is held");
  f.field("travel_speed", s.travel_speed, Range{1e-3, 2.0}, "m/s", "between strokes");
  f.field("travel_acceleration", s.travel_acceleration, Range{0.01, 20.0}, "m/s²",
          "between strokes");
  f.field("turn_speed", s.turn_speed, Range{0.01, 10.0}, "rad/s",
          "of the pen axis between strokes");
  f.field("turn_acceleration", s.turn_acceleration, Range{0.01, 100.0}, "rad/s²",
          "of the pen axis between strokes");
  f.field("safe_height", s.safe_height, Range{0.0, 1.0}, "m",
          "above the highest point of the drawing, for travel");
  f.field("smoothing_time", s.smoothing_time, Range{0.0, 1.0}, "s",
          "over which an acceleration builds up");
  f.field("corner_angle", s.corner_angle_deg, Range{1.0, 180.0}, "deg",
          "a sharper turn is a corner: full stop");
  f.field("normal_smoothing", s.normal_smoothing, Range{0.0, 0.1}, "m",
          "over which the normals along a stroke are averaged");
  f.field("tolerance", s.tolerance, Range{1e-7, 1e-2}, "m", "of the desired line to the artwork");
}

namespace {

void describe_axial(Fields& f, const std::string& what, AxialGain& tangent_and_normal,
                    const std::string& unit, Range range, const std::string& help) {
  f.field(what + "_tangent", tangent_and_normal.tangent, range, unit,
          help + " along (about) both tangents of the surface");
  f.field(what + "_normal", tangent_and_normal.normal, range, unit,
          help + " along (about) its normal");
}

}  // namespace

void describe(Fields& f, ContactSettings& s) {
  f.field("enter_distance", s.enter_distance, Range{0.0, 0.05}, "m",
          "contact can begin so near to the estimated surface");
  f.field("search_distance", s.search_distance, Range{0.0, 0.05}, "m",
          "the same with a measured wrench, whatever the estimate is off by");
  f.field("leave_distance", s.leave_distance, Range{0.0, 0.1}, "m", "and is lost beyond this");
  f.field("touch_force", s.touch_force, Range{0.0, 50.0}, "N", "measured along the normal: touch");
  f.field("touch_gap", s.touch_gap, Range{1e-5, 0.02}, "m",
          "without a wrench: the tip stays so far behind the approach: touch");
  f.field("loss_force", s.loss_force, Range{0.0, 50.0}, "N", "measured: below it ...");
  f.field("loss_time", s.loss_time, Range{0.0, 5.0}, "s", "... for so long the contact is lost");
  f.field("lost_surface_time", s.lost_surface_time, Range{0.0, 5.0}, "s",
          "how long the last normal is trusted when the cloud has none");
}

void describe(Fields& f, ObserverSettings& s) {
  f.field("enabled", s.enabled, "works with a measured wrench only");
  f.field("bandwidth", s.bandwidth, Range{1.0, 900.0}, "rad/s",
          "of the low-pass through which what the model misses is seen");
  f.field("limit", s.limit, Range{0.0, 1000.0}, "Nm", "of what it may take off each joint");
}

void describe(Fields& f, ForceIntegralSettings& s) {
  f.field("enabled", s.enabled, "works with a measured wrench only");
  f.field("rate", s.rate, Range{0.01, 50.0}, "1/s", "of push per force error");
  f.field("limit", s.limit, Range{0.0, 50.0}, "N", "of what it may add to the push");
}

void describe(Fields& f, Tool& s) {
  f.field("mass", s.mass, Range{0.0, 20.0}, "kg", "./impedraw calibrate-tool finds it");
  f.field("centre", s.p_SC, Range{-1.0, 1.0}, "m", "of mass, in the sensor's frame");
}

void describe(Fields& f, SensingSettings& s) {
  f.field("tool", s.tool, "what hangs on the sensor, as believed");
  f.field("remove_weight", s.removal.weight, "the tool's weight is taken out of the reading");
  f.field("remove_inertia", s.removal.inertia, "and what its acceleration takes");
  f.field("remove_coriolis", s.removal.coriolis, "and what its turning takes");
  f.field("tip_distance", s.tip_distance, Range{0.0, 2.0}, "m",
          "of the tip from the sensor, along the pen, as believed");
  f.field("sensor_delay", s.sensor_delay, Range{0.0, 0.03}, "s", "as believed; null: what it is");
  f.field("filter_bandwidth", s.filter_bandwidth, Range{0.0, 1900.0}, "rad/s",
          "of the wrench's low-pass; 0: none");
  f.field("tare_time", s.tare_time, Range{0.01, 60.0}, "s",
          "of rest in the air before the first stroke");
}

void describe(Fields& f, ControlSettings& s) {
  f.choice("inertia", s.inertia,
           {{"natural", InertiaShaping::natural},
            {"scaled", InertiaShaping::scaled},
            {"shaped", InertiaShaping::shaped}},
           "M_d: the arm's own, a multiple of it, or the one below");
  f.choice("wrench", s.source,
           {{"none", WrenchSource::none},
            {"true", WrenchSource::truth},
            {"sensor", WrenchSource::sensor},
            {"realistic", WrenchSource::realistic}},
           "F_ext that the controller is given: none, the simulator's, a sensor's (wrench_sensor), "
           "a real sensor's");
  f.choice("projection", s.projection,
           {{"lifted", ErrorProjection::lifted}, {"paper", ErrorProjection::paper}},
           "of the error in contact (13)");
  describe_axial(f, "stiffness", s.stiffness.linear, "N/m", Range{0.0, 20000.0}, "K;");
  describe_axial(f, "rotational_stiffness", s.stiffness.angular, "Nm/rad", Range{0.0, 1000.0},
                 "K;");
  describe_axial(f, "reference_stiffness", s.reference_stiffness.linear, "N/m", Range{0.0, 20000.0},
                 "K' that sizes damping where K is zero;");
  describe_axial(f, "reference_rotational_stiffness", s.reference_stiffness.angular, "Nm/rad",
                 Range{0.0, 1000.0}, "K' that sizes damping where K is zero;");
  describe_axial(f, "mass", s.shaped_inertia.linear, "kg", Range{0.0, 1000.0, true},
                 "M_d if shaped;");
  describe_axial(f, "rotational_inertia", s.shaped_inertia.angular, "kg m²",
                 Range{0.0, 100.0, true}, "M_d if shaped;");
  f.field("inertia_scale", s.inertia_scale, Range{0.01, 100.0}, "",
          "M_d over the arm's own, if scaled");
  f.field("damping_ratio", s.damping_ratio, Range{0.05, 3.0}, "", "of every mode");
  f.field("push", s.normal_force, Range{0.0, 50.0}, "N", "along the normal, in contact");
  f.field("switch_time", s.switch_time, Range{0.001, 5.0}, "s",
          "time constant in which a switch of mode hands over force");
  f.field("approach_speed", s.approach_speed, Range{1e-4, 0.2}, "m/s",
          "along the normal, until touch");
  f.field("approach_overtravel", s.approach_overtravel, Range{0.0, 0.1}, "m",
          "beneath the estimated surface, then the approach waits");
  f.field("approach_lag", s.approach_lag, Range{1e-4, 0.05}, "m",
          "the approach waits for a tip that is held back by more");
  f.field("retreat_height", s.retreat_height, Range{0.0, 0.5}, "m",
          "above the plan once the surface was lost");
  f.field("normal_bandwidth", s.normal_bandwidth, Range{1.0, 500.0}, "rad/s",
          "of the tracker of the surface normal");
  f.field("tip_radius", s.tip_radius, Range{0.0, 0.05}, "m", "believed");
  f.field("tip_stiffness", s.tip_stiffness, Range{0.0, 1e7}, "N/m",
          "believed, along the normal; 0: rigid");
  f.field("friction", s.friction, Range{0.0, 3.0}, "",
          "believed: what of a measured wrench tip friction may explain");
  f.field("friction_feedforward", s.friction_feedforward, Range{0.0, 3.0}, "",
          "believed: foreseen along the stroke without a wrench");
  f.field("contact_stiffness_max", s.contact_stiffness_max, Range{1.0, 1e7}, "N/m",
          "stiffest tip and canvas that the set-up is checked against");
  f.field("natural_mass_max", s.natural_mass_max, Range{0.1, 1000.0}, "kg",
          "largest natural mass along the normal in that check");
  f.field("null_stiffness", s.null_stiffness, Range{0.0, 500.0}, "Nm/rad",
          "K_q of the null space (15)");
  f.field("null_damping_ratio", s.null_damping_ratio, Range{0.0, 3.0}, "", "of the null space");
  f.field("observer", s.observer, "of what the model of the arm misses");
  f.field("torque_delay", s.torque_delay, Range{0.0, 0.02}, "s",
          "of the drives, as the observer believes");
  f.field("loop_delay", s.loop_delay, Range{0.0, 0.02}, "s",
          "age of the state when a torque acts, that damping is checked against");
  f.field("force_integral", s.force_integral, "of the force error, along the normal");
  f.field("sensing", s.sensing, "from the sensor's readings to the wrench at the tip");
  f.field("torque_share", s.torque_share, Range{0.01, 1.0}, "",
          "of the arm's torque limits that is used");
  f.field("torque_rate", s.torque_rate, Range{1.0, 1e6}, "Nm/s", "that no joint's torque exceeds");
  f.field("limit_margin", s.limit_margin, Range{0.001, 1.0}, "rad",
          "so near to its limit a joint is pushed back, in the null space");
  f.field("limit_torque", s.limit_torque, Range{0.0, 300.0}, "Nm", "by this at the limit");
  f.field("tip_speed_limit", s.tip_speed_limit, Range{0.001, 5.0}, "m/s",
          "of the speed that the law asks for");
  f.field("max_state_age", s.max_state_age, Range{0.0, 1.0}, "s",
          "joints read longer ago are stale");
  f.field("max_wrench_age", s.max_wrench_age, Range{0.0, 1.0}, "s", "and so is a wrench");
  f.field("contact", s.contact, "when contact begins and ends");
}

void describe(Fields& f, TipMaterial& s) {
  f.field("radius", s.radius, Range{1e-5, 0.05}, "m", "of the tip sphere");
  f.field("stiffness", s.stiffness, Range{10.0, 1e7}, "N/m", "along the normal");
  f.field("damping", s.damping, Range{0.0, 1e5}, "N s/m", "along the normal");
  f.field("friction", s.friction, Range{0.0, 3.0}, "", "Coulomb's, tip on canvas");
}

void describe(Fields& f, ModelErrors& s) {
  f.field("mass_scale", s.mass_scale, Range{0.1, 10.0}, "",
          "mass and inertia of every link and the pen over what is believed");
  f.field("centre_shift", s.centre_shift, Range{-0.2, 0.2}, "m", "of every link's centre of mass");
  f.field("viscous_friction", s.viscous_friction, Range{0.0, 100.0}, "Nm s/rad", "on every joint");
  f.field("rotor_inertia", s.rotor_inertia, Range{0.0, 10.0}, "kg m²", "on every joint");
  f.field("torque_ripple", s.torque_ripple, Range{0.0, 20.0}, "Nm", "amplitude, on every joint");
  f.field("torque_quantum", s.torque_quantum, Range{0.0, 10.0}, "Nm", "to which torque is rounded");
  f.field("loop_delay", s.loop_delay, Range{0.0, 0.015}, "s", "until a torque acts");
  f.field("pen_longer", s.pen_longer, Range{-0.02, 0.02}, "m", "than believed");
}

void describe(Fields& f, WrenchSensorSettings& s) {
  f.field("noise_force", s.noise_force, Range{0.0, 100.0}, "N",
          "standard deviation of a sample at 1 kHz");
  f.field("noise_torque", s.noise_torque, Range{0.0, 10.0}, "Nm",
          "standard deviation of a sample at 1 kHz");
  f.field("bias_force", s.bias_force, Range{0.0, 1000.0}, "N", "its direction comes from the seed");
  f.field("bias_torque", s.bias_torque, Range{0.0, 100.0}, "Nm",
          "its direction comes from the seed");
  f.field("drift_force", s.drift_force, Range{0.0, 100.0}, "N/min", "of the bias");
  f.field("drift_torque", s.drift_torque, Range{0.0, 10.0}, "Nm/min", "of the bias");
  f.field("quantum_force", s.quantum_force, Range{0.0, 10.0}, "N", "to which it is rounded");
  f.field("quantum_torque", s.quantum_torque, Range{0.0, 1.0}, "Nm", "to which it is rounded");
  f.field("range_force", s.range_force, Range{0.0, 1e5}, "N", "beyond which it saturates; 0: none");
  f.field("range_torque", s.range_torque, Range{0.0, 1e4}, "Nm",
          "beyond which it saturates; 0: none");
  f.field("delay", s.delay, Range{0.0, 0.03}, "s", "of its readings");
}

void describe(Fields& f, WorldSettings& s) {
  f.field("errors", s.errors, "what the arm is beyond what is believed");
  f.field("tip", s.tip, "the pen's tip as it is");
  f.field("joint_friction", s.joint_friction, Range{0.0, 50.0}, "Nm", "dry, on every joint");
  f.field("gravity", s.gravity, Range{0.0, 100.0}, "m/s²", "along -z");
}

void describe(Fields& f, PenSettings& s) {
  f.field("width", s.width, Range{0.01, 20.0}, "mm", "of its line at the nominal force");
  f.field("width_per_newton", s.width_per_newton, Range{-10.0, 10.0}, "mm/N",
          "wider for each newton above; 0: the same throughout");
  f.field("nominal_force", s.nominal_force, Range{0.0, 100.0}, "N", "at which it has that width");
}

void describe(Fields& f, PushSettings& s) {
  f.field("force", s.force, Range{0.0, 200.0}, "N", "on the pen tip");
  f.field("direction", s.direction_W, Range{-1.0, 1.0}, "",
          "world; its part along the canvas's tangent plane counts");
  f.field("lift", s.lift, Range{-200.0, 200.0}, "N", "and this along the canvas's outward normal");
  f.field("middle", s.middle, Range{0.0, 1.0}, "",
          "when: share of the time from the first stroke's start to the last one's end");
  f.field("duration", s.duration, Range{0.0, 1000.0}, "s", "how long");
}

void describe(Fields& f, FaultSettings& s) {
  f.choice("kind", s.kind,
           {{"nan_state", FaultKind::nan_state},
            {"stale_state", FaultKind::stale_state},
            {"nan_wrench", FaultKind::nan_wrench},
            {"stale_wrench", FaultKind::stale_wrench},
            {"no_cloud", FaultKind::no_cloud},
            {"slow_step", FaultKind::slow_step}},
           "what goes wrong around the controller");
  f.field("middle", s.middle, Range{0.0, 1.0}, "",
          "when it begins: share of the time from the first stroke's start to the last one's end");
  f.field("duration", s.duration, Range{0.0, 1000.0}, "s", "how long");
}

void describe(Fields& f, LogSettings& s) {
  f.choice("rate", s.rate, {{"reduced", LogRate::reduced}, {"full", LogRate::full}},
           "full: everything of every control step; reduced: a sixth of its size, the same "
           "metrics.json, and rows at 62.5 Hz and at the extremes of the force");
}

void describe(Fields& f, Scenario& s) {
  f.field("name", s.name, "of the run");
  f.field("seed", s.seed, Range{0, 1e9}, "", "of everything random");
  f.field("drawing", s.drawing, "what is drawn");
  f.field("canvas", s.canvas, "on what");
  f.field("arm", s.arm, "with what");
  f.field("perception", s.perception, "what is seen of the canvas");
  f.field("blind", s.blind, "what is done without");
  f.field("path", s.path, "how the tip moves");
  f.field("preflight", s.preflight, "what is checked before anything moves");
  f.field("control", s.control, "the law");
  f.field("world", s.world, "the simulated truth");
  f.field("wrench_sensor", s.wrench_sensor,
          "between flange and pen, where control.wrench is sensor");
  f.field("pen", s.pen, "the line it leaves, for the pictures");
  f.field("log", s.log, "how much of the run it keeps");
  f.field("pushes", s.pushes, "disturbances");
  f.field("faults", s.faults, "put on purpose");
}

}  // namespace impedraw
