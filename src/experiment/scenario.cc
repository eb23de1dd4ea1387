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
          "Where the middle of the drawing goes in the drawing plane (x, y).");
  f.for_users();
  f.field(Limits::scale, s.scale,
          "Millimetres on the canvas per millimetre on the page; null: set by one of the sizes.");
  f.field(Limits::width, s.width_mm,
          "Size of the drawing across the page; null: set by another size.");
  f.for_users();
  f.field(Limits::height, s.height_mm,
          "Size of the drawing down the page; null: set by another size.");
  f.for_users();
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
          "Rotation of the drawing, counter-clockwise as seen from above.");
  f.for_users();
  f.field("mirror", s.mirror, "Mirrors the drawing left to right.");
}

void describe(Fields& f, TextSettings& s) {
  using Limits = TextSettings::Limits;
  f.field("text", s.text,
          "Text to write in single strokes; \\n starts a new line; empty: the file or the shape is "
          "drawn.");
  f.for_users();
  f.field("font", s.font,
          "Hershey font: futural, rowmans, scripts, gothiceng, ... (/usr/share/hershey-fonts).");
  f.for_users();
  f.field(Limits::size, s.size_mm,
          "Height of the capitals, on the canvas if the placement gives no size; null: the text is "
          "fitted as a file is.");
  f.for_users();
  f.choice("align", s.align,
           {{"left", TextAlign::left}, {"centre", TextAlign::centre}, {"right", TextAlign::right}},
           "Alignment of the lines.");
  f.field(Limits::line_spacing, s.line_spacing,
          "Distance between baselines, as a multiple of the capitals' height.");
}

void describe(Fields& f, HatchSettings& s) {
  using Limits = HatchSettings::Limits;
  f.field(Limits::spacing, s.spacing_mm,
          "Distance, on the canvas, between the lines that stand for a fill; 0: fills are not "
          "hatched. White is never hatched.");
  f.for_users();
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
  using Limits = DrawingSettings::Limits;
  f.field("shape", s.shape,
          "Built-in drawing: sine, M, sine10 or circle. It is used if svg and text are empty.");
  f.for_users();
  f.field("svg", s.svg,
          "File to draw: .svg, or strokes as .txt, .strokes or .csv; empty: the shape is drawn.");
  f.for_users();
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
  f.choice("visible", s.visible, {{"as-painted", Visible::as_painted}, {"all", Visible::all}},
           "What of an SVG is drawn. as-painted: what the eye sees; opaque fills, clip paths and "
           "masks hide lines, and white is not drawn. all: every line, as if nothing were hidden.");
  f.choice("layers", s.layers,
           {{"auto", LayerSource::automatic},
            {"groups", LayerSource::groups},
            {"colours", LayerSource::colours}},
           "What an SVG's layers are; each is drawn before the next. groups: Inkscape's layers and "
           "other groups at the top of the document. auto: its groups; its colours where there is "
           "one group at most, without a name, and two to eight colours.");
  f.field("layer", s.layer,
          "Layers that are drawn, by number or name, as in '2,black'; empty: all of them.");
  f.for_users();
  f.field(Limits::join_gap, s.join_gap_mm,
          "Largest gap on the page between ends of strokes that are joined; 0: none are joined.");
  f.field("dashes", s.dashes, "Draws dashed lines of an SVG as dashes.");
  f.field("hatch", s.hatch, "Hatching of an SVG's filled areas.");
  f.field(Limits::simplify, s.simplify_mm,
          "Largest distance, on the page, by which a stroke may change when points are dropped; 0: "
          "every point is kept.");
  f.field("keep_order", s.keep_order,
          "Keeps the order of the strokes in the file instead of shortening the travel between "
          "them.");
  f.field(
      Limits::tilt, s.tilt_deg,
      "Roll, pitch and yaw of the drawing plane about the world's origin; [0, -90, 0] is a wall "
      "that faces the arm.");
  f.choice("mapping", s.mapping, {{"project", Mapping::project}, {"wrap", Mapping::wrap}},
           "How the page reaches the surface: projected along the drawing axis, or wrapped like a "
           "sheet, which preserves lengths.");
  f.for_users();
  f.field("wrap", s.wrap, "How the surface is flattened for mapping: wrap.");
  f.field("skip_unreachable", s.skip_unreachable,
          "Leaves out and reports what fails the pre-flight; otherwise nothing is drawn.");
  f.for_users();
  f.field("redraw", s.redraw,
          "Draws the parts that got no ink, judged by contact and force, once more at the end.");
  f.field(Limits::dry_run, s.dry_run,
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
  using Limits = ArmSettings::Limits;
  f.choice(
      "driver", s.driver,
      {{"sim", ArmDriver::sim}, {"iiwa-lcm", ArmDriver::iiwa_lcm}, {"franka", ArmDriver::franka}},
      "Who moves the arm: the simulator here, KUKA's iiwa over LCM, or Franka's FR3 through its "
      "control interface (docs/arms.md).");
  f.for_users();
  f.field("url", s.url,
          "iiwa-lcm: the LCM broker, as in tcpq://127.0.0.1:7701. franka: the arm, as in "
          "fci://172.16.0.2.");
  f.for_users();
  f.choice("clock", s.clock, {{"wall", ArmClock::wall}, {"lock_step", ArmClock::lock_step}},
           "Not sim: wall: states come by the arm's own clock; lock_step: the arm is simulated "
           "and waits for the answer to each state.");
  f.field(Limits::delay, s.delay,
          "Not sim: time from a state until the torque that answers it acts; control.loop_delay "
          "is then at least one step longer.");
  f.field(Limits::wrench_delay, s.wrench_delay,
          "iiwa-lcm: age of the wrench at the tip when it arrives, for control.wrench: "
          "ground_truth, which is then what the channel IMPEDRAW_TIP_WRENCH carries.");
  f.field(Limits::max_silence, s.max_silence,
          "Not sim: time without a state, by the wall clock, after which the session ends.");
  f.field(Limits::recoveries, s.recoveries,
          "franka: how often in a run the arm may be asked to recover from a reflex, after which "
          "the drawing goes on. Never after a collision.");
  f.field("real_time", s.real_time,
          "Not sim, clock: wall: the loop's thread asks the system for real-time priority and "
          "locked memory; where it gets none, a note says so.");
  f.field("urdf", s.urdf, "URDF of the arm with its pen; empty: the iiwa 14 in models/.");
  f.for_users();
  f.field(kRotorInertia, s.rotor_inertia,
          "Inertia of the rotors about the joints' axes, reflected through their gears, as the "
          "controller's model has it: one for all joints or one for each; empty: what the URDF's "
          "impedraw element says, else none.");
  f.or_one();
  f.field(Limits::posture_seed, s.posture_seed,
          "Joint angles from which the inverse kinematics starts, one per joint; empty: those of "
          "the iiwa for seven joints, else found by a search.");
  f.field(Limits::q_0, s.q_0,
          "Rest posture of the null space, one angle per joint; empty: the posture over the middle "
          "of the drawing.");
  f.field(Limits::start, s.start_p_WE,
          "Position of the pen tip during the snapshot and at the start.");
}

void describe(Fields& f, FenceSettings& s) {
  using Limits = FenceSettings::Limits;
  f.field(Limits::low, s.low, "Lowest coordinates that the tip may have.");
  f.field(Limits::high, s.high, "Highest coordinates that the tip may have.");
  f.field(Limits::force, s.force,
          "Measured force on the tip that ends the run; null: 150 N, where it is measured. Needs "
          "control.wrench.");
  f.field(Limits::moment, s.moment,
          "Measured moment at the tip that ends the run; null: 30 Nm, where it is measured. Needs "
          "control.wrench.");
  f.field(Limits::speed, s.speed, "Speed of the tip that ends the run; null: none.");
  f.field(Limits::lag, s.lag,
          "Distance of the tip from the point that it is driven to that ends the run after 0.1 s.");
}

void describe(Fields& f, CameraSettings& s) {
  using Limits = CameraSettings::Limits;
  f.field(Limits::position, s.p_WC, "Position of the pinhole.");
  f.field(Limits::target, s.target_W, "Point in the middle of the image.");
  f.field(Limits::width, s.width, "Width of the image.");
  f.field(Limits::height, s.height, "Height of the image.");
  f.field(Limits::fov_y, s.fov_y_deg, "Vertical field of view.");
}

void describe(Fields& f, DepthNoise& s) {
  f.field(DepthNoise::Limits::sigma_at_1m, s.sigma_at_1m,
          "Standard deviation of the depth at 1 m; it grows with depth². A real camera has 0.001.");
  f.field(DepthNoise::Limits::quantum_at_1m, s.quantum_at_1m,
          "Resolution of the depth at 1 m; it grows with depth². 0: continuous.");
}

void describe(Fields& f, CameraErrors& s) {
  f.field(CameraErrors::Limits::shift, s.shift,
          "Distance of each true camera from where it is believed to be. Its direction comes from "
          "the seed.");
  f.field(
      CameraErrors::Limits::turn, s.turn_deg,
      "Angle of each true camera to how it is believed to stand. Its axis comes from the seed.");
  f.field(CameraErrors::Limits::depth_scale, s.depth_scale,
          "Relative error of every depth: 0.01 reads 1 % too far.");
  f.field(CameraErrors::Limits::time_stamp, s.time_stamp,
          "How much later than its exposure a frame's time stamp is.");
}

void describe(Fields& f, NormalSettings& s) {
  using Limits = NormalSettings::Limits;
  f.choice("mode", s.mode,
           {{"fresh", NormalMode::fresh}, {"interpolated", NormalMode::interpolated}},
           "Whether the normal is fitted anew at each step or interpolated between normals fitted "
           "once.");
  f.field(Limits::k, s.k, "Number of nearest neighbours, equation (18).");
  f.field(Limits::max_radius, s.max_radius, "Largest distance of a neighbour from the query.");
  f.choice("weighting", s.weighting,
           {{"uniform", NeighbourWeighting::uniform}, {"smooth", NeighbourWeighting::smooth}},
           "Weights of the neighbours: all equal, as in the paper, or fading out with distance.");
  f.choice("fit", s.fit, {{"plane", SurfaceFit::plane}, {"quadric", SurfaceFit::quadric}},
           "Surface fitted through the neighbours: a plane, as in the paper, or a quadric.");
  f.field(Limits::max_one_sidedness, s.max_one_sidedness,
          "One-sidedness of the neighbours above which the tip is taken to be off the cloud's "
          "edge.");
}

void describe(Fields& f, FrameSettings& s) {
  using Limits = FrameSettings::Limits;
  f.field("enabled", s.enabled, "Cameras keep capturing; off: one snapshot before drawing.");
  f.field(Limits::rate, s.rate, "Frames of each camera in a second.");
  f.field(Limits::latency, s.latency, "Mean time from a frame's exposure to its use.");
  f.field(Limits::latency_jitter, s.latency_jitter, "Standard deviation of that time.");
  f.field(Limits::drop, s.drop, "Share of the frames that never arrive.");
  f.field(
      Limits::stamp_error, s.stamp_error,
      "Subtracted from a frame's time stamp to have its exposure; ./impedraw arm camera-latency "
      "finds it.");
  f.field("prediction", s.prediction,
          "Predicts the canvas's pose from the last frame to the present; off: to see its worth.");
  f.field("feedforward", s.feedforward,
          "Feeds the canvas's velocity and acceleration forward; off: to see their worth.");
  f.field("wait_for_rest", s.wait_for_rest,
          "For a canvas that is moved by hand between strokes: while it moves, the pen waits above "
          "it and the plan's clock stands.");
  f.field(Limits::skew, s.skew, "Time from one camera's exposure to the next one's.");
  f.field("depth", s.depth,
          "Frames carry depths, by which the canvas's own shape tells where it is; off: marks "
          "alone do.");
  f.field(Limits::depth_every, s.depth_every, "Every how many-th frame carries depths.");
  f.field("grow_surface", s.grow_surface,
          "Depths improve the surface under the pen; off: it stays as the snapshot saw it.");
  f.field("region_of_interest", s.region_of_interest,
          "A simulator casts only the rays of a frame that may meet the canvas; off: every pixel. "
          "The images are the same.");
  f.field(Limits::width, s.width, "Width of a frame.");
  f.field(Limits::height, s.height, "Height of a frame.");
}

void describe(Fields& f, Fiducial& s) {
  f.field(Fiducial::Limits::position, s.p_K, "Position, while the canvas has not moved.");
}

void describe(Fields& f, FiducialSettings& s) {
  f.field("points", s.points, "Marks on the canvas's frame.");
  f.field(FiducialSettings::Limits::noise, s.noise,
          "Standard deviation of each axis of a mark's position in one frame of one camera.");
}

void describe(Fields& f, PerceptionSettings& s) {
  using Limits = PerceptionSettings::Limits;
  f.field("enabled", s.enabled, "Uses the depth cameras; off: blind stiffness control.");
  f.choice("source", s.source,
           {{"simulated", PerceptionSource::simulated},
            {"capture", PerceptionSource::capture},
            {"cloud", PerceptionSource::cloud}},
           "What the cloud is made from. simulated: images rendered of the canvas; capture: the "
           "depth images in perception.capture; cloud: the points in perception.cloud.");
  f.for_users();
  f.field("capture", s.capture, "Folder with capture.json and depth images, for source: capture.");
  f.for_users();
  f.field("cloud", s.cloud, "File with points in W, in m, .ply, .pcd or .xyz, for source: cloud.");
  f.for_users();
  f.field(Limits::viewpoint, s.viewpoint,
          "Whence the points of the cloud were seen, x, y, z of one place or of several; empty: as "
          "the file says, or from above.");
  f.field("align", s.align, "Puts the views of a capture onto each other.");
  f.field("find_canvas", s.find_canvas,
          "Leaves out of a capture or a cloud the table, and objects that the drawing does not lie "
          "on.");
  f.field("cameras", s.cameras, "Depth cameras, which take one snapshot before drawing.");
  f.field("noise", s.noise, "Noise of the depth.");
  f.field("errors", s.errors, "Differences of the true cameras from what is believed of them.");
  f.field(Limits::voxel, s.voxel,
          "Side of the cubes in which points are averaged; 0: every point is kept.");
  f.field("adapt", s.adapt,
          "Uses smaller patches, down to a quarter, where the surface is rougher than noise "
          "explains.");
  f.field(Limits::self_padding, s.self_padding,
          "Distance from the arm below which points are removed.");
  f.field(Limits::region_lower, s.region_lower, "Lower corner of the region of interest.");
  f.field(Limits::region_upper, s.region_upper, "Upper corner of the region of interest.");
  f.field("normals", s.normals, "Surface normals from the cloud, equations (18) and (19).");
  f.field("frames", s.frames, "Frames of cameras that keep capturing.");
  f.field("fiducials", s.fiducials, "Marks that tell where the canvas is.");
  f.field(Limits::watch, s.watch,
          "Time for which the arm watches the canvas before the first stroke.");
  f.choice("canvas_pose", s.canvas_pose,
           {{"tracked", CanvasPoseSource::tracked}, {"true", CanvasPoseSource::truth}},
           "Where the pose of a moving canvas comes from. tracked: the frames; true: the "
           "simulator, to judge the controller alone.");
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
  using Limits = BlindSettings::Limits;
  f.choice("height", s.height,
           {{"canvas", BlindHeight::canvas},
            {"plane", BlindHeight::plane},
            {"touch", BlindHeight::touch}},
           "What is known of the surface's height without perception. canvas: all; plane: that it "
           "lies between plane_z, where the set-point is, and top_z; touch: the same, and it is "
           "found and followed by the measured wrench.");
  f.field(Limits::plane_z, s.plane_z,
          "Level beneath the surface, along the drawing axis, for height: plane and touch.");
  f.field(Limits::top_z, s.top_z,
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
  f.field(Limits::draw_speed, s.draw_speed, "Speed along a stroke, on the surface.");
  f.for_users();
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

namespace {

// "Stiffness K along both tangents." and "... along the normal.", or about them.
void describe_axial(Fields& f, const Limit& limit, AxialGain& gain, const std::string& help) {
  const std::string name(limit.name), unit(limit.unit);
  f.field(name + "_tangent", gain.tangent, limit.range, unit,
          help + " both tangents of the surface.");
  f.field(name + "_normal", gain.normal, limit.range, unit, help + " the surface normal.");
}

}  // namespace

void describe(Fields& f, ContactSettings& s) {
  using Limits = ContactSettings::Limits;
  f.field(Limits::enter_distance, s.enter_distance,
          "Distance to the estimated surface below which contact can begin without a measured "
          "wrench.");
  f.constant(Limits::search_distance, s.search_distance);
  f.field(Limits::leave_distance, s.leave_distance,
          "Distance to the estimated surface above which contact is lost.");
  f.field(Limits::touch_force, s.touch_force, "Measured normal force above which the pen touches.");
  f.field(Limits::touch_gap, s.touch_gap,
          "Lag of the tip behind the approach above which the pen touches, without a measured "
          "wrench.");
  f.constant(Limits::loss_force, s.loss_force);
  f.constant(Limits::loss_time, s.loss_time);
  f.field(Limits::lost_surface_time, s.lost_surface_time,
          "Time for which the last normal is trusted when perception has no surface.");
}

void describe(Fields& f, ObserverSettings& s) {
  using Limits = ObserverSettings::Limits;
  f.field("enabled", s.enabled, "Uses the observer. It needs a measured wrench.");
  f.field(Limits::bandwidth, s.bandwidth, "Bandwidth of the observer's low-pass filter.");
  f.field(Limits::limit, s.limit, "Largest torque that the observer compensates on a joint.");
  f.field(
      Limits::yield_limit, s.yield_limit,
      "Torque of each joint above which, and above 12 % of its weight torque on top, the observer "
      "compensates only what would move the tip, so that the arm yields to a push on its body; "
      "empty: 0.5 % of the joint's torque limit, at least 1.5 Nm.");
}

void describe(Fields& f, FeltNormalSettings& s) {
  using Limits = FeltNormalSettings::Limits;
  f.field(Limits::share, s.share,
          "Of the felt normal, beyond the deviation, in the normal that the law follows. 0: the "
          "force tells nothing of the surface. Where it is not given: 0, but 0.5 where the surface "
          "under the drawing is rough.");
  f.field(Limits::deviation, s.deviation,
          "Tangent of the angle between felt and perceived normal below which the perceived one is "
          "believed.");
  f.field(Limits::force_error, s.force_error, "Error of the measured force across the normal.");
}

void describe(Fields& f, ForceIntegralSettings& s) {
  using Limits = ForceIntegralSettings::Limits;
  f.field("enabled", s.enabled, "Uses the integral. It needs a measured wrench.");
  f.field(Limits::rate, s.rate, "Integral gain.");
  f.field(Limits::limit, s.limit, "Largest force that the integral adds to the normal force.");
}

void describe(Fields& f, Tool& s) {
  using Limits = Tool::Limits;
  f.field(Limits::mass, s.mass, "Mass of the tool. ./impedraw calibrate-tool identifies it.");
  f.field(Limits::centre, s.p_SC, "Centre of mass in the sensor's frame.");
}

void describe(Fields& f, SensingSettings& s) {
  using Limits = SensingSettings::Limits;
  f.field("tool", s.tool, "Model of the tool below the sensor.");
  f.field("remove_weight", s.removal.weight, "Removes the tool's weight from the reading.");
  f.field("remove_inertia", s.removal.inertia,
          "Removes the wrench that accelerates the tool from the reading.");
  f.field("remove_coriolis", s.removal.coriolis,
          "Removes the tool's centrifugal and gyroscopic wrench from the reading.");
  f.field(Limits::tip_distance, s.tip_distance,
          "Modelled distance of the tip from the sensor, along the pen.");
  f.field(Limits::sensor_delay, s.sensor_delay,
          "Modelled delay of the sensor; null: its true delay.");
  f.field(Limits::filter_bandwidth, s.filter_bandwidth,
          "Bandwidth of the wrench's low-pass filter; 0: no filter.");
  f.field(Limits::tare_time, s.tare_time,
          "Time at rest in the air, before the first stroke, over which the sensor is tared.");
}

void describe(Fields& f, JointSensingSettings& s) {
  using Limits = JointSensingSettings::Limits;
  f.choice("velocity", s.velocity,
           {{"measured", VelocitySource::measured}, {"estimated", VelocitySource::estimated}},
           "Joint velocities of the control law: as measured, or estimated from the positions, the "
           "torques and the arm's model.");
  f.field(Limits::bandwidth, s.bandwidth, "Bandwidth of the estimator.");
  f.field(
      Limits::least_bandwidth, s.least_bandwidth,
      "Noise of the positions, as measured, lowers the bandwidth to this at the most, or as far "
      "as the stability checks allow.");
  f.field(Limits::sensor_delay, s.sensor_delay,
          "Modelled delay of the joints' sensors; null: their true delay.");
}

void describe(Fields& f, ControlSettings& s) {
  using Limits = ControlSettings::Limits;
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
  describe_axial(f, Limits::stiffness, s.stiffness.linear, "Stiffness K along");
  describe_axial(f, Limits::rotational_stiffness, s.stiffness.angular, "Stiffness K about");
  describe_axial(f, Limits::reference_stiffness, s.reference_stiffness.linear,
                 "Stiffness K' that sets the damping where K is zero, along");
  describe_axial(f, Limits::reference_rotational_stiffness, s.reference_stiffness.angular,
                 "Stiffness K' that sets the damping where K is zero, about");
  f.field("mass_tangent", s.shaped_inertia.linear.tangent, Limits::mass.range,
          std::string(Limits::mass.unit),
          "Desired mass for inertia: shaped, along both tangents of the surface.");
  f.field(
      "mass_normal", s.mass_normal, Limits::mass.range, std::string(Limits::mass.unit),
      "Desired mass for inertia: shaped, along the surface normal. A lighter pen follows a rough "
      "surface with a steadier force. null: 1.5 kg, with perception.frames 0.8 kg, or 1.3 times "
      "the "
      "lightest that is stable with a wrench as late as control.sensing makes it.");
  describe_axial(f, Limits::rotational_inertia, s.shaped_inertia.angular,
                 "Desired moment of inertia for inertia: shaped, about");
  f.field(Limits::inertia_scale, s.inertia_scale,
          "Desired inertia as a multiple of the arm's own, for inertia: scaled.");
  f.field(Limits::damping_ratio, s.damping_ratio, "Damping ratio of every mode.");
  f.field(Limits::normal_force, s.normal_force,
          "Normal force that the pen presses with while drawing.");
  f.for_users();
  f.formerly("push");
  f.field(Limits::switch_time, s.switch_time,
          "Time constant of the transition between contact modes.");
  f.field(Limits::approach_speed, s.approach.speed,
          "Speed along the normal until the pen touches.");
  f.constant(Limits::approach_overtravel, s.approach.overtravel);
  f.field(Limits::approach_lag, s.approach.lag, "Lag of the tip above which the approach waits.");
  f.field(Limits::retreat_height, s.approach.retreat_height,
          "Height above the plan to which the pen retreats when the surface is lost.");
  f.field(Limits::normal_bandwidth, s.surface.normal_bandwidth,
          "Bandwidth of the filter of the surface normal.");
  f.choice(
      "pen_axis", s.surface.pen_axis, {{"plan", PenAxis::plan}, {"surface", PenAxis::surface}},
      "Pen's axis while drawing: along the plan's smoothed normals, or along the estimated normal "
      "at "
      "the tip. Where it is not given: surface, but plan where the surface under the drawing is "
      "rough. The pen pushes along the estimated normal either way.");
  f.field(Limits::tip_radius, s.tip.radius, "Modelled radius of the tip.");
  f.field(Limits::tip_stiffness, s.tip.stiffness,
          "Modelled stiffness of the tip along the normal; 0: rigid.");
  f.field(Limits::friction, s.friction.coefficient,
          "Modelled coefficient of friction: the part of a measured wrench that tip friction can "
          "explain.");
  f.field(
      Limits::normal_error, s.friction.normal_error_deg,
      "The estimated normal may err by this angle. The part of a measured wrench that the error "
      "explains, up to its tangent times the normal force, does not push the pen aside. Where it "
      "is not given: 0, but 30 where the surface under the drawing is rough.");
  f.field(Limits::friction_feedforward, s.friction.feedforward,
          "Modelled coefficient of friction that is compensated along a stroke without a measured "
          "wrench.");
  f.field(Limits::contact_stiffness_max, s.stability_check.contact_stiffness_max,
          "Stiffest contact of tip and canvas in the stability check at set-up.");
  f.field(Limits::natural_mass_max, s.stability_check.natural_mass_max,
          "Largest effective mass along the normal in the stability check at set-up.");
  f.field(Limits::null_stiffness, s.null_stiffness,
          "Stiffness K_q of the null space, equation (15), one per joint; empty: 10 each.");
  f.field(Limits::null_damping_ratio, s.null_space.damping_ratio,
          "Damping ratio of the null space.");
  f.field("observer", s.observer, "Momentum observer of the torque that the arm's model misses.");
  f.field(
      Limits::torque_delay, s.torque_delay,
      "Delay of the drives; loop_delay is then at least one step longer. null: loop_delay alone "
      "counts.");
  f.field(Limits::loop_delay, s.timing.loop_delay,
          "Greatest age of the state while a torque acts: one step and the delay of the drives.");
  f.field("felt_normal", s.felt_normal,
          "The surface's normal as the measured force tells it, where perception smooths it.");
  f.field("force_integral", s.force_integral, "Integral of the force error along the normal.");
  f.field("sensing", s.sensing, "From the sensor's readings to the wrench at the tip.");
  f.field("joint_sensing", s.joint_sensing,
          "From the joints' readings to their positions and velocities.");
  f.field(Limits::torque_share, s.torque_share,
          "Fraction of the arm's torque limits that may be used.");
  f.field(Limits::torque_rate, s.torque_rate, "Largest rate of change of a joint's torque.");
  f.field(
      Limits::joint_speed_share, s.joint_speed_share,
      "Fraction of the arm's joint speed limits that the control law may ask for; faster joints "
      "are damped.");
  f.field("check_rotors", s.check_rotors,
          "Refuses a simulated arm whose rotors differ from arm.rotor_inertia by more than the law "
          "bears.");
  f.field(Limits::limit_margin, s.joint_range.margin,
          "Distance from its limit at which a joint is pushed back, in the null space.");
  f.constant(Limits::limit_torque, s.joint_range.torque);
  f.field(Limits::tip_speed_limit, s.limits.tip_speed,
          "Largest tip speed that the control law may ask for.");
  f.field(Limits::turn_speed_limit, s.limits.turn_speed,
          "Largest angular speed of the pen's axis that the control law may ask for.");
  f.field(Limits::max_state_age, s.timing.max_state_age, "Age above which a joint state is stale.");
  f.field(Limits::max_wrench_age, s.timing.max_wrench_age, "Age above which a wrench is stale.");
  f.field("contact", s.contact, "When contact begins and ends.");
}

void describe(Fields& f, TipMaterial& s) {
  using Limits = TipMaterial::Limits;
  f.field(Limits::radius, s.radius, "Radius of the tip sphere.");
  f.field(Limits::stiffness, s.stiffness, "Stiffness along the normal.");
  f.field(Limits::damping, s.damping, "Damping along the normal.");
  f.field(Limits::friction, s.friction, "Coulomb friction coefficient of tip and canvas.");
}

void describe(Fields& f, ModelErrors& s) {
  using Limits = ModelErrors::Limits;
  f.field(Limits::mass_scale, s.mass_scale,
          "True mass and inertia of every link and the pen as a multiple of the modelled ones.");
  f.field(Limits::centre_shift, s.centre_shift, "Shift of every link's centre of mass.");
  f.field(Limits::viscous_friction, s.viscous_friction, "Viscous friction of every joint.");
  f.field(Limits::rotor_inertia, s.rotor_inertia,
          "True rotor inertia: one for all joints or one for each; empty: as arm.rotor_inertia.");
  f.or_one();
  f.field(Limits::torque_ripple, s.torque_ripple, "Amplitude of the torque ripple of every joint.");
  f.field(Limits::torque_quantum, s.torque_quantum,
          "Resolution of the joint torques; 0: continuous.");
  f.field(Limits::loop_delay, s.loop_delay, "Delay after which a commanded torque acts.");
  f.field(Limits::pen_longer, s.pen_longer, "Length of the true pen beyond the modelled one.");
}

void describe(Fields& f, WrenchSensorSettings& s) {
  using Limits = WrenchSensorSettings::Limits;
  f.field(Limits::noise_force, s.noise_force, "Standard deviation of a force sample at 1 kHz.");
  f.field(Limits::noise_torque, s.noise_torque, "Standard deviation of a torque sample at 1 kHz.");
  f.field(Limits::bias_force, s.bias_force,
          "Magnitude of the force bias. Its direction comes from the seed.");
  f.field(Limits::bias_torque, s.bias_torque,
          "Magnitude of the torque bias. Its direction comes from the seed.");
  f.field(Limits::drift_force, s.drift_force, "Drift of the force bias.");
  f.field(Limits::drift_torque, s.drift_torque, "Drift of the torque bias.");
  f.field(Limits::quantum_force, s.quantum_force, "Resolution of the force; 0: continuous.");
  f.field(Limits::quantum_torque, s.quantum_torque, "Resolution of the torque; 0: continuous.");
  f.field(Limits::range_force, s.range_force, "Force at which an axis saturates; 0: never.");
  f.field(Limits::range_torque, s.range_torque, "Torque at which an axis saturates; 0: never.");
  f.field(Limits::delay, s.delay, "Delay of the readings.");
}

void describe(Fields& f, JointSensorSettings& s) {
  using Limits = JointSensorSettings::Limits;
  f.field(Limits::quantum, s.quantum, "Resolution of the joint positions; 0: continuous.");
  f.field(Limits::position_noise, s.position_noise,
          "Standard deviation of the white noise of a position sample.");
  f.field(Limits::velocity_noise, s.velocity_noise,
          "Standard deviation of the white noise of a velocity sample.");
  f.field(Limits::delay, s.delay, "Delay of the readings.");
  f.choice("velocity", s.velocity,
           {{"exact", VelocityReading::exact},
            {"difference", VelocityReading::difference},
            {"none", VelocityReading::none}},
           "Velocities that the sensors give: the true ones, the filtered difference of the "
           "positions, or none; none needs control.joint_sensing.velocity: estimated.");
  f.field(Limits::velocity_bandwidth, s.velocity_bandwidth,
          "Bandwidth of the low-pass filter of the difference; 0: no filter.");
}

void describe(Fields& f, WorldSettings& s) {
  using Limits = WorldSettings::Limits;
  f.field("errors", s.errors, "Differences between the true arm and its model.");
  f.field("tip", s.tip, "True properties of the pen's tip.");
  f.field(Limits::joint_friction, s.joint_friction, "Coulomb friction of every joint.");
  f.field(Limits::gravity, s.gravity, "Gravity along -z.");
  f.field("joint_sensor", s.joint_sensor, "Faults of the joints' sensors.");
  f.field(Limits::substeps, s.substeps,
          "Integration steps in each control step; the torque is held.");
}

void describe(Fields& f, PenSettings& s) {
  using Limits = PenSettings::Limits;
  f.field(Limits::width, s.width, "Line width at the nominal force.");
  f.for_users();
  f.field(Limits::width_per_newton, s.width_per_newton,
          "Change of the line width with the force; 0: constant width.");
  f.field(Limits::nominal_force, s.nominal_force, "Force at which the line has its nominal width.");
  f.field(Limits::least_force, s.least_force,
          "Least force of lines whose width or force is given: by an SVG's stroke-width, where the "
          "width changes with the force, or by a stroke file's column.");
  f.field(Limits::most_force, s.most_force, "Their greatest force.");
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
}

void describe(Fields& f, ToolSettings& s) {
  using Limits = ToolSettings::Limits;
  f.choice("kind", s.kind,
           {{"pen", ToolKind::pen}, {"pad", ToolKind::pad}},
           "What touches the canvas. pen: the ball of world.tip. pad: a rigid disc with a layer of "
           "foam.");
  f.field(Limits::radius, s.radius, "Radius of the pad.");
  f.field(Limits::foam_thickness, s.foam_thickness, "Thickness of the pad's foam.");
  f.field(Limits::foam_stiffness, s.foam_stiffness, "Pressure of the foam per compression.");
  f.field(Limits::foam_damping, s.foam_damping, "Pressure of the foam per rate of compression.");
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

void describe(Fields& f, PushSettings& s) {
  using Limits = PushSettings::Limits;
  f.field(Limits::force, s.force, "Force: tangential on the pen tip, or as it is on a link.");
  f.field("link", s.link,
          "Link of the arm that is pushed at its origin, such as link_4, the elbow; empty: the "
          "pen.");
  f.field(Limits::direction, s.direction_W,
          "Direction of the force in world axes; on the pen it is projected onto the canvas's "
          "tangent plane.");
  f.field(Limits::lift, s.lift, "Additional force on the pen along the canvas's outward normal.");
  f.field(Limits::middle, s.middle,
          "Middle of the push, as a fraction of the time from the start of the first stroke to the "
          "end of the last.");
  f.field(Limits::duration, s.duration, "Duration of the push.");
}

void describe(Fields& f, FaultSettings& s) {
  using Limits = FaultSettings::Limits;
  f.choice("kind", s.kind,
           {{"nan_state", FaultKind::nan_state},
            {"stale_state", FaultKind::stale_state},
            {"nan_wrench", FaultKind::nan_wrench},
            {"stale_wrench", FaultKind::stale_wrench},
            {"no_cloud", FaultKind::no_cloud},
            {"no_frames", FaultKind::no_frames},
            {"slow_step", FaultKind::slow_step},
            {"jumped_state", FaultKind::jumped_state},
            {"drifting_state", FaultKind::drifting_state},
            {"standing_state", FaultKind::standing_state},
            {"false_speed", FaultKind::false_speed},
            {"false_wrench", FaultKind::false_wrench},
            {"future_wrench", FaultKind::future_wrench}},
           "Fault around the controller.");
  f.field(Limits::start, s.start,
          "Start of the fault, as a fraction of the time from the start of the first stroke to the "
          "end of the last.");
  f.formerly("middle");
  f.field(Limits::duration, s.duration, "Duration of the fault.");
}

void describe(Fields& f, LogSettings& s) {
  f.choice("rate", s.rate, {{"reduced", LogRate::reduced}, {"full", LogRate::full}},
           "full: everything of every control step; reduced: a sixth of its size, the same "
           "metrics.json, and rows at 62.5 Hz and at the extremes of the force");
}

void describe(Fields& f, Scenario& s) {
  using Limits = Scenario::Limits;
  f.field("name", s.name, "Name of the run, and of its folder.");
  f.for_users();
  f.field(Limits::seed, s.seed, "Seed of all random numbers.");
  f.for_users();
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

}  // namespace impedraw
