// A mesh seen from above, as background of a picture: heights, shading, contours and outline.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

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

  // Brightness of the cell, 0 … 1, lit from the upper left; NaN off the mesh.
  double shade(int row, int column) const;
};

// `view` maps a vertex to (u, v, height). `cells` is the number of cells along the longer side.
Relief make_relief(const std::vector<Eigen::Vector3d>& vertices,
                   const std::vector<Eigen::Vector3i>& triangles,
                   const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& view,
                   int cells = 400);

}  // namespace impedraw
