// Where a page lies in the world, seen along −z.
//
//   p_W = centre + s R(rotate) (−Y', −X') / 1000,  (X', Y') = page point − page origin [mm], X' →
//   −X' first where mirrored
//
// Seen from above with world +x up and −y to the right, the page reads as on a screen: X to the
// right, Y down. `rotate_deg` turns it counter-clockwise in that view. `s` is the scale (1: a
// page's millimetre is a millimetre in the drawing plane).
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/common/range.h"
#include "impedraw/drawing/stroke.h"

namespace impedraw {

// How large, and which point of the page goes to the centre. At most one of the sizes may be given,
// fit_width and fit_height being one together; with none the artwork is fitted to the circle. The
// artwork's extent is that of its strokes and areas.
struct PlacementSettings {
  Eigen::Vector2d centre_m{0.60, 0.0};
  std::optional<double> scale;      // size: given outright
  std::optional<double> width_mm;   // size: of the strokes' bounding box on the page's X
  std::optional<double> height_mm;  // size: on its Y
  // size: as large as a rectangle about the centre allows, less the margin on each side. It lies
  // with the world's axes, its width along y_W and its height along x_W, however the artwork is
  // turned within it.
  std::optional<double> fit_width_m;  // absent: that way it is not bounded
  std::optional<double> fit_height_m;
  double margin_mm = 0;
  // the whole page is to lie in it, and its middle at the centre, instead of the artwork's box
  bool fit_page = false;
  // else: the farthest point of a stroke lies on this circle about the centre
  double fit_radius_m = 0.15;
  // the page's (0, 0) goes to the centre, else the middle of the strokes' bounding box
  bool about_page_origin = false;
  double rotate_deg = 0;
  bool mirror = false;

  struct Limits {
    static constexpr Range centre = {-2.0, 2.0};           // [m]
    static constexpr Range size = Range::positive();       // scale, and width and height [mm]
    static constexpr Range fit = Range::positive_to(2.0);  // rectangle and radius [m]
    static constexpr Range margin = Range::to_below(0.0, 1000.0);  // [mm], half of the largest side
    static constexpr Range rotate = {-360.0, 360.0};               // [deg]
  };
};

// Is any size given, so that it is not for the circle to say?
bool has_size(const PlacementSettings& settings);

// The built-in shapes': scale 1 about the page's origin.
PlacementSettings shape_placement(const Eigen::Vector2d& centre_m = {0.60, 0.0});

struct Placement {
  Eigen::Vector2d centre_m{0.60, 0.0};
  Eigen::Vector2d origin_mm = Eigen::Vector2d::Zero();  // the page point that goes there
  Eigen::Matrix2d A = (Eigen::Matrix2d() << 0, -1e-3, -1e-3, 0).finished();  // [m/mm]

  Eigen::Vector2d to_plane(const Eigen::Vector2d& page_mm) const {
    return centre_m + A * (page_mm - origin_mm);
  }
  Eigen::Vector2d to_page(const Eigen::Vector2d& world_m) const {
    return origin_mm + A.inverse() * (world_m - centre_m);
  }
  double scale() const { return 1e3 * std::sqrt(std::abs(A.determinant())); }
};

// InputError: a setting out of range, two sizes at once, a margin that leaves
// nothing, a margin or page without a rectangle, nothing to fit.
Placement place(const Artwork& artwork, const PlacementSettings& settings);

// A stroke, or a span of one, where it will be drawn, as the planner takes it: the same points in
// the world's xy [m] and on the page [mm].
struct PlacedStroke {
  std::vector<Eigen::Vector2d> p_P;   // in the drawing plane [m]
  std::vector<Eigen::Vector2d> page;  // [mm]
  int number = 0;                     // of the artwork's stroke, counted from 0
  // where on that stroke the first point lies: length in the world's xy from the stroke's own first
  // point [m]
  double start = 0;
};
std::vector<PlacedStroke> placed_strokes(const Artwork& artwork, const Placement& placement);

}  // namespace impedraw
