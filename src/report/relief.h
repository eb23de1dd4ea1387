// A mesh seen from above, as a picture's background: what is on top where, its shading, height
// contours and outline.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace impedraw {

// View coordinates (u to the right, v down) in mm; heights in mm along the line of sight, towards
// the viewer.
struct Relief {
  using Line = std::vector<Eigen::Vector2d>;

  Eigen::AlignedBox2d area;  // that the grid spans
  int columns = 0, rows = 0;
  Eigen::MatrixXd height;      // rows×columns, at cell centres; NaN where there is nothing
  std::vector<Line> contours;  // at whole multiples of contour_step
  double contour_step = 0.0;
  std::vector<Line>
      outline;  // the mesh's edges that belong to one triangle; none for a closed body

  // Light on the cell, 0 … 1, from the upper left; NaN where there is nothing.
  double shade(int row, int column) const;
};

// `view` takes a vertex to (u, v, height). `cells` along the longer side.
Relief make_relief(const std::vector<Eigen::Vector3d>& vertices,
                   const std::vector<Eigen::Vector3i>& triangles,
                   const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& view,
                   int cells = 400);

}  // namespace impedraw
