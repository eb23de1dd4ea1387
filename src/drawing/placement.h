// Places a page in the world, seen along −z.
//
//   p_W = centre + s R(rotate) (−Y', −X') / 1000,  (X', Y') = page point − page origin [mm]
//
// A mirrored page first maps X' to −X'.
//
// Seen from above, with world +x up and −y to the right, the page reads as on a screen: X to the
// right, Y down. `rotate_deg` turns it counter-clockwise in that view. `s` is the scale (1: a
// millimetre on the page is a millimetre in the drawing plane).
#pragma once

#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/common/range.h"
#include "impedraw/drawing/stroke.h"

namespace impedraw {

// The size, and the page point that goes to the centre. At most one size may be given; fit_width
// and fit_height count as one. Without a size the artwork is fitted to the circle. The artwork's
// extent is that of its strokes and areas.
struct PlacementSettings {
  Eigen::Vector2d centre_m{0.60, 0.0};
  std::optional<double> scale;      // size: the scale
  std::optional<double> width_mm;   // size: of the strokes' bounding box along the page's X
  std::optional<double> height_mm;  // size: along its Y
  // size: the largest that fits a rectangle about the centre, less the margin on each side. The
  // rectangle is aligned with the world axes, its width along y_W and its height along x_W, however
  // the artwork is rotated within it.
  std::optional<double> fit_width_m;  // absent: unbounded in that direction
  std::optional<double> fit_height_m;
  double margin_mm = 0;
  // fit the whole page, with its middle at the centre, instead of the artwork's box
  bool fit_page = false;
  // without a size: the farthest point of a stroke lies on this circle about the centre
  double fit_radius_m = 0.15;
  // the page's (0, 0) goes to the centre; else the middle of the strokes' bounding box does
  bool about_page_origin = false;
  double rotate_deg = 0;
  bool mirror = false;

  struct Limits {
    static constexpr Limit centre = {"centre", "m", {-10.0, 10.0}};
    static constexpr Limit scale = {"scale", "", Range::positive()};
    static constexpr Limit width = {"width", "mm", Range::positive()};
    static constexpr Limit height = {"height", "mm", Range::positive()};
    static constexpr Limit fit_width = {"fit_width", "m", Range::positive_to(2.0)};
    static constexpr Limit fit_height = {"fit_height", "m", Range::positive_to(2.0)};
    static constexpr Limit fit_radius = {"fit_radius", "m", Range::positive_to(2.0)};
    // half of the largest side
    static constexpr Limit margin = {"margin", "mm", Range::to_below(0.0, 1000.0)};
    static constexpr Limit rotate = {"rotate", "deg", {-360.0, 360.0}};
  };
};

// True if a size is given, so that the circle does not apply.
bool has_size(const PlacementSettings& settings);

// The placement of the built-in shapes: scale 1 about the page's origin.
PlacementSettings shape_placement(const Eigen::Vector2d& centre_m = {0.60, 0.0});

struct Placement {
  Eigen::Vector2d centre_m{0.60, 0.0};
  Eigen::Vector2d origin_mm = Eigen::Vector2d::Zero();  // the page point at the centre
  Eigen::Matrix2d A = (Eigen::Matrix2d() << 0, -1e-3, -1e-3, 0).finished();  // [m/mm]

  Eigen::Vector2d to_plane(const Eigen::Vector2d& page_mm) const {
    return centre_m + A * (page_mm - origin_mm);
  }
  Eigen::Vector2d to_page(const Eigen::Vector2d& world_m) const {
    return origin_mm + A.inverse() * (world_m - centre_m);
  }
  double scale() const { return 1e3 * std::sqrt(std::abs(A.determinant())); }
};

// InputError: a setting out of range, two sizes at once, a margin that leaves no space, a margin or
// fit_page without a rectangle, or nothing to fit.
Placement place(const Artwork& artwork, const PlacementSettings& settings);

// A stroke, or a span of one, as the planner takes it: the same points in the world's xy [m] and on
// the page [mm].
struct PlacedStroke {
  std::vector<Eigen::Vector2d> p_P;   // in the drawing plane [m]
  std::vector<Eigen::Vector2d> page;  // [mm]
  int number = 0;                     // index of the artwork's stroke, from 0
  // arc length in the world's xy from the stroke's first point to this span's first point [m]
  double start = 0;
  double speed = 0;                // of the pen [m/s]; 0: path.draw_speed
  double wait = 0;                 // before it, with the pen up [s]
  bool pause = false;              // before it, until the run is told to go on
  std::vector<double> force = {};  // of the pen at each point [N]; empty: control.normal_force
  double depth = 0;                // that a cutter holds [m]; 0: by the force alone
  // Most that the tool leans off the drawing axis, on the way there and off it [rad].
  double lean_there = kWayLean, lean_off = kWayLean;

  // An arm reaches far over a steep surface with that.
  static constexpr double kWayLean = 35.0 * std::numbers::pi / 180.0;
};
std::vector<PlacedStroke> placed_strokes(const Artwork& artwork, const Placement& placement);

}  // namespace impedraw
