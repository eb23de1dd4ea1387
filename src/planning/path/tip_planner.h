// Plans the pen tip's motion in time (tip_path.h) from strokes placed on the page.
//
// Speed along a stroke, for a span of its spline p(u) with |dp/du| ≤ g, |d²p/du²| ≤ κ:
//   u̇ ≤ min(draw_speed / g, √(0.8 A / κ)).
// ü is limited so that the acceleration u̇² p'' + ü p', seen along the drawing axis, stays within
// A = draw_acceleration; κ counts that part alone, too. Across the surface u̇² |n·p''| stays within
// normal_acceleration. (With vertical_pen, A limits the whole.)
// The pen's axis n(u) turns within tilt_speed and tilt_acceleration in the same way.
// speed_profile.h computes the fastest motion under these limits.
#pragma once

#include <functional>
#include <numbers>
#include <optional>
#include <vector>

#include "impedraw/common/pose.h"
#include "impedraw/drawing/placement.h"
#include "impedraw/planning/path/tip_path.h"
#include "impedraw/planning/surface_height.h"

namespace impedraw {

struct PathSettings {
  Pose X_WP;  // drawing frame P of strokes and surface, z out of the drawing plane
  Eigen::Vector3d start_p_WE{0.5, 0.0, 0.5};             // tip position at t = 0 [m]
  Eigen::Vector3d start_n_W = Eigen::Vector3d::UnitZ();  // −z_E at t = 0; unit
  double start_hold = 0.0;           // rest at the start, for taring a wrench sensor [s]
  double hover_height = 0.003;       // start of the approach: above the first point, along n [m]
  double approach_speed = 0.010;     // [m/s]
  double settle_time = 0.4;          // rest at the first point, before drawing [s]
  double draw_speed = 0.05;          // [m/s]
  double draw_acceleration = 0.2;    // [m/s²]; speeds and accelerations are those of pen plotters
  double end_hold = 0.05;            // rest at the last point, before the lift [s]
  double dot_time = 0.1;             // hold time of a dot, in addition to settle_time [s]
  double travel_speed = 0.2;         // [m/s]
  double travel_acceleration = 0.4;  // [m/s²]
  double turn_speed = 1.0;           // of n during travel [rad/s]
  double turn_acceleration = 4.0;    // [rad/s²]
  double safe_height = 0.03;         // travel height above the surface's highest point [m]
  // From a place that is steeper, a lift goes straight up once it is clear of the surface [rad].
  double steep = 35.0 * std::numbers::pi / 180.0;
  // the surface's highest point [m]; default: the highest that the strokes touch
  std::optional<double> highest_z;
  double smoothing_time = 0.04;  // time over which an acceleration builds up [s]
  double corner_angle_deg = 25;  // a larger turn is a corner: full stop
  double tolerance = 1e-5;  // largest distance between desired line and artwork, seen along z [m]
  double rounding = 5e-5;   // the same beside bends made of straight lines (stroke_fit.h) [m]
  double knot_spacing = 1e-3;  // largest distance between surface queries along a stroke [m]
  // length of stroke over which normals are averaged (stroke_fit.h) [m]
  double normal_smoothing = 5e-3;
  // Along a stroke the pen's axis is the surface normal. Where that would turn faster than these
  // limits at draw_speed, it is smoothed until it keeps them or leaves the normal by the allowance;
  // what is still too fast is drawn slower.
  double tilt_allowance_deg = 10;
  double lean_deg = 0;            // of that axis towards z_P, at most (leant.h)
  double tilt_speed = 1.5;        // [rad/s]
  double tilt_acceleration = 20;  // [rad/s²]
  // Across the surface, by its curvature: the tip's inertia then changes the contact force by less
  // than a newton [m/s²].
  double normal_acceleration = 0.35;
  // Across the surface, where it is rougher than it is known: the normal's error times the speed
  // [m/s]. The tip's damping times this changes the contact force by about a newton.
  double normal_speed = 0.008;
  // At draw_speed, where a stroke's force changes [N/s]; steeper ones are spread (force_profile.h).
  double force_rate = 100;
  double joint_speed_share = 0.7;  // of the arm's joint speeds, along a stroke (joint_rates.h)
  double joint_acceleration = 25;  // of each joint, along a stroke [rad/s²]
  // of the torque that the controller may use, for holding, pressing and motion along a stroke
  double joint_torque_share = 0.8;
  bool vertical_pen = false;  // n = +z always (blind)
  // depth of the desired point below the surface while the pen is down (blind) [m]
  double sink = 0;
  // A led tool's heading; none: the heading is free. Along strokes it turns within turn_speed and
  // turn_acceleration, too.
  std::optional<ToolHeading> heading;
};

// Throws InputError naming the setting, its value and the allowed range.
void validate(const PathSettings& settings);

// Lowers the limits on u̇ and ü of a spline's spans, one entry per span: what else limits the speed,
// such as the arm's joints (joint_rates.h).
using SpanLimits = std::function<void(const PathSpline&, std::vector<SpeedSpan>*)>;

// Throws InputError for a setting out of range (name, value, limit), a stroke point without surface
// (stroke, position, distance), or no strokes.
TipPath plan_tip_path(const std::vector<PlacedStroke>& strokes, const SurfaceHeight& surface,
                      const PathSettings& settings = {}, const SpanLimits& limits = {});

}  // namespace impedraw
