// A piece of the surface as a height field on a regular grid of the drawing plane: the mesh that is
// laid flat.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "impedraw/planning/surface_height.h"

namespace impedraw {

// Node (i, j) stands at corner + spacing (i, j), i along x and j along y; it is stored at i +
// columns j, and so is the cell whose lower corner it is. Cells are squares in the plane, each two
// triangles, split along alternating diagonals; counter-clockwise seen from +z.
struct SurfacePatch {
  Eigen::Vector2d corner = Eigen::Vector2d::Zero();  // [m]
  double spacing = 0;                                // [m]
  int columns = 0, rows = 0;
  std::vector<int> vertex;  // of each node, −1 where it has none; columns · rows
  std::vector<char>
      cell;  // whether it belongs to the patch; columns · rows, false in the last column and row
  std::vector<SurfaceSample> samples;  // of the vertices
  std::vector<Eigen::Vector3i> triangles;
  int centre = -1;  // the vertex above the centre

  int node(int i, int j) const { return i + columns * j; }
};

// The part of the surface that hangs together with the point above `centre`, which becomes a node:
// cells of which all four corners have surface and lie where `desired` says so, within `half_width`
// of the centre in x and y and within `reach` of it along the surface (the length of a way along
// edges and diagonals: up to 8 % longer than the shortest). Cells with an edge steeper than 80° are
// left out: a height field does not tell a wall from two surfaces, one above the other.
//
// The surface is asked row by row, back and forth, so that each point is near the last one.
// InputError: centre without surface or cells.
SurfacePatch make_patch(const SurfaceHeight& surface, const Eigen::Vector2d& centre, double spacing,
                        double half_width, double reach,
                        const std::function<bool(const Eigen::Vector2d&)>& desired);

}  // namespace impedraw
