// Lines on which a round footprint covers an area of the surface.
//
// Centres   where the footprint keeps `margin` from every edge, and all of it would touch:
//           δ + h_i > 0 for at least kTouching of its places, δ the mean compression of its foam,
//           h_i the height of place i over the footprint's plane
// Edge      a closed line along the border of the centres, more than one round where rows are dense
// Rings     more lines along the border, where the layout has them: closed, none where the area is
//           narrow
// Rows      level sets of the distance from a line across the middle (surface_grid.h), `spacing`
//           apart on the surface or less, so that the outer ones lie beside the edge's line
// Passes    the edge's lines, then the rows there and back, joined by bends as wide as their
//           distance, lifted only where a join would leave the centres
// Rounded   a polyline has its bend in its corners, where the path would have to slow down
#pragma once

#include <vector>

#include <Eigen/Core>

#include "impedraw/planning/cover/pressed_foot.h"

namespace impedraw {

struct CoverWish {
  Footprint footprint;
  double spacing = 0.0134;      // of the rows [m]
  double direction_deg = 90.0;  // of the rows, from the plane's x axis
  double margin = 1e-3;         // [m]
  std::vector<char> region;     // of the grid's vertices that are wanted; empty: all
  std::vector<double> share;    // of the most, that each vertex is to get; empty: all the same
};

inline constexpr double kTouching = 0.98;

// The vertices on which the footprint may be centred.
struct Centres {
  PressedFeet feet;
  std::vector<double> clearance;  // to the border of the centres, < 0 beyond it [m]
  std::vector<char> allowed;
  std::vector<double>
      within_reach;     // distance from where the arm does not come; empty: unknown [m]
  double wanted = 0.0;  // area of the surface that is known and wanted [m²]
  std::size_t on_edge = 0, uneven = 0;  // vertices that an edge, or an uneven footprint, rules out
};
Centres footprint_centres(const SurfaceGrid& grid, const CoverWish& wish);

struct CoverLines {
  std::vector<std::vector<Eigen::Vector2d>> passes;  // in the plane [m]
  std::size_t edges = 0;                             // the first passes, on the border
  std::size_t rows = 0;                              // lines that are level sets
};
// The area decides which of the two leaves less uneven.
enum class Layout { rows, rings };
CoverLines cover_lines(const SurfaceGrid& grid, const Centres& centres, const CoverWish& wish,
                       Layout layout = Layout::rows);

// The cubic B-spline with these control points, by points at most `step` apart: its curvature is
// continuous, and it stays in their convex hull. It has the line's ends, or stays closed.
std::vector<Eigen::Vector2d> rounded(const std::vector<Eigen::Vector2d>& line, double step);

// By how much less than the footprint a promise reaches from its lines: the pad strays [m]. By how
// much it leans, as a cloud's noise makes it: a place must lie deeper in the foam than that [rad].
inline constexpr double kAstray = 0.25e-3, kLean = 0.035;

// Asks for v's place as it is seen, and on either side of that; true if all answers are. Beside a
// steep border, a place that lies off the surface as it was seen may lie out from under the
// footprint's rim.
template <class Ask>
bool wherever_it_lies(const SurfaceGrid& grid, std::size_t v, Ask&& ask) {
  const Eigen::Vector3d p = grid.point(v);
  if (grid.unsure.empty()) return ask(p);
  const Eigen::Vector3d off(0.0, 0.0, grid.unsure[v] * grid.area[v] / (grid.step * grid.step));
  return ask(p) && ask(p - off) && ask(p + off);
}

// The vertices that a disc of this radius covers, centred on each place of the lines.
std::vector<char> swept(const SurfaceGrid& grid,
                        const std::vector<std::vector<Eigen::Vector2d>>& lines, double radius);
// The vertices that the pressed footprint touches there, though it strays and leans.
std::vector<char> surely_pressed(const SurfaceGrid& grid,
                                 const std::vector<std::vector<Eigen::Vector2d>>& lines,
                                 const PressedFeet& feet);
// And centred on each allowed vertex: what a perfect planner would reach.
std::vector<char> swept(const SurfaceGrid& grid, const Centres& centres, double radius);

// Those of the places that lie at least this far inside of their border [m].
std::vector<char> inside_by(const SurfaceGrid& grid, const std::vector<char>& places,
                            double distance);

double area_of(const SurfaceGrid& grid, const std::vector<char>& places);  // [m²]

}  // namespace impedraw
