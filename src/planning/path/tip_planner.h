// From strokes laid on the page to the pen tip's motion in time (tip_path.h tells what that is made
// of).
//
// Speed along a stroke, for a span of its spline p(u) with |dp/du| ≤ g, |d²p/du²| ≤ κ:  u̇ ≤
// min(draw_speed / g, √(0.8 A / κ)), and ü so
// that the whole acceleration u̇² p'' + ü p' stays within A = draw_acceleration. speed_profile.h
// makes the fastest motion of it.
#pragma once

#include <optional>

#include "impedraw/common/pose.h"
#include "impedraw/common/range.h"
#include "impedraw/drawing/placement.h"
#include "impedraw/planning/path/tip_path.h"
#include "impedraw/planning/surface_height.h"

namespace impedraw {

struct PathSettings {
  Pose X_WP;  // drawing frame P, z out of the drawing plane; strokes and surface are in it
  Eigen::Vector3d start_p_WE{0.5, 0.0, 0.5};             // where the tip is when time begins [m]
  Eigen::Vector3d start_n_W = Eigen::Vector3d::UnitZ();  // and −z_E there; unit
  double start_hold = 0.0;         // at rest at the start: a wrench sensor is tared then [s]
  double hover_height = 0.003;     // above the first point, along n: the approach begins there [m]
  double approach_speed = 0.010;   // [m/s]
  double settle_time = 0.4;        // at the first point, before drawing [s]
  double draw_speed = 0.05;        // [m/s]
  double draw_acceleration = 0.2;  // [m/s²]; speeds and accelerations are those of pen plotters
  double end_hold = 0.05;          // at the last point, before the lift [s]
  double dot_time = 0.1;           // a stroke of one point is held that long, besides settling [s]
  double travel_speed = 0.2;       // [m/s]
  double travel_acceleration = 0.4;  // [m/s²]
  double turn_speed = 1.0;           // of n while travelling [rad/s]
  double turn_acceleration = 4.0;    // [rad/s²]
  double safe_height = 0.03;         // above the highest point of the surface, for travel [m]
  std::optional<double>
      highest_z;                 // of the surface [m]; left out, the highest that the strokes touch
  double smoothing_time = 0.04;  // over which an acceleration builds up [s]
  double corner_angle_deg = 25;  // a turn above this is a corner: full stop
  double tolerance = 1e-5;  // largest distance of the desired line to the artwork, seen along z [m]
  double knot_spacing = 1e-3;  // the surface is asked at least this often along a stroke [m]
  // normals are averaged over so much of the stroke (stroke_fit.h) [m]
  double normal_smoothing = 5e-3;
  bool vertical_pen = false;  // n = +z always (blind)
  // the desired point lies this far beneath the surface while the pen is down (blind) [m]
  double sink = 0;

  struct Limits {
    // A tare, of up to 60 s, lengthens it.
    static constexpr Range start_hold = {0.0, 120.0};
    static constexpr Range hover_height = Range::positive_to(0.1);
    static constexpr Range approach_speed = {1e-4, 0.2};
    static constexpr Range settle_time = {0.0, 10.0};
    static constexpr Range draw_speed = {1e-4, 1.0};
    static constexpr Range draw_acceleration = {0.01, 20.0};
    static constexpr Range end_hold = {0.0, 10.0};
    static constexpr Range dot_time = {0.0, 10.0};
    static constexpr Range travel_speed = {1e-3, 2.0};
    static constexpr Range travel_acceleration = {0.01, 20.0};
    static constexpr Range turn_speed = {0.01, 10.0};
    static constexpr Range turn_acceleration = {0.01, 100.0};
    static constexpr Range safe_height = Range::positive_to(1.0);
    static constexpr Range smoothing_time = {0.0, 1.0};
    static constexpr Range corner_angle = Range::to_below(1.0, 90.0);
    static constexpr Range tolerance = {1e-7, 1e-2};
    static constexpr Range knot_spacing = Range::positive();
    static constexpr Range normal_smoothing = {0.0, 0.1};
    static constexpr Range sink = Range::at_least(0.0);
  };
};

// Throws InputError: the setting, its value and what is allowed.
void validate(const PathSettings& settings);

// InputError: a setting out of range (name, value, limit), a stroke point without surface (stroke,
// place, distance), no strokes.
TipPath plan_tip_path(const std::vector<PlacedStroke>& strokes, const SurfaceHeight& surface,
                      const PathSettings& settings = {});

}  // namespace impedraw
