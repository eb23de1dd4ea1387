// A mesh seen from above, as background of a picture: heights, shading, contours and outline, and
// how Cairo draws it. Private to src/report.
#pragma once

#include <functional>
#include <vector>

#include <cairo.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/report/sheet.h"

namespace impedraw {

// View coordinates (u to the right, v down) in mm. Heights in mm along the line of sight, positive
// towards the viewer.
struct Relief {
  using Line = std::vector<Eigen::Vector2d>;

  Eigen::AlignedBox2d area;  // spanned by the grid
  int columns = 0, rows = 0;
  Eigen::MatrixXd height;      // rows×columns, at cell centres; NaN off the mesh
  std::vector<Line> contours;  // at integer multiples of contour_step
  double contour_step = 0.0;
  std::vector<Line> outline;  // edges that belong to one triangle only; empty for a closed body
  std::vector<Line> seen_outline;  // of them, those that nothing hides
  // rows×columns: the cell shows the inside of a body, through a hole; false throughout if most of
  // the mesh is seen from there
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> inside;
  // The outline encloses what is seen: a sheet, and no body with holes.
  bool is_sheet = false;

  Raster shading;  // rows×columns

  // Brightness of the cell, 0 … 1, lit from the upper left; NaN off the mesh.
  double shade(int row, int column) const;
};

// `view` maps a vertex to (u, v, height). `cells` is the number of cells along the longer side.
Relief make_relief(const std::vector<Eigen::Vector3d>& vertices,
                   const std::vector<Eigen::Vector3i>& triangles,
                   const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& view,
                   int cells = 400);

// Draws a relief with Cairo: shading, contours, outline. Private to src/report.

inline constexpr Colour kContour{0.55, 0.50, 0.42}, kOutline{0.36, 0.33, 0.29};

void draw_relief(cairo_t* cr, const Relief& relief);

// Appends p unless it is nearer than `step` to the last point of the line.
void extend(std::vector<Eigen::Vector2d>& line, const Eigen::Vector2d& p, double step, bool always);

// Extends the box by `share` of its longer side, at least 1 mm.
Eigen::AlignedBox2d with_margin(Eigen::AlignedBox2d box, double share);

}  // namespace impedraw
