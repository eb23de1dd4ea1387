// A piece of the surface as a height field on a regular grid of the drawing plane. This is the mesh
// that is flattened.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "impedraw/planning/surface_height.h"

namespace impedraw {

// Node (i, j) is at corner + spacing (i, j), i along x and j along y. It is stored at index
// i + columns j, as is the cell whose lower corner it is. Cells are squares in the plane. Each is
// split into two triangles along alternating diagonals, counter-clockwise seen from +z.
struct SurfacePatch {
  Eigen::Vector2d corner = Eigen::Vector2d::Zero();  // [m]
  double spacing = 0;                                // [m]
  int columns = 0, rows = 0;
  std::vector<int> vertex;  // vertex of each node, −1 if none; columns · rows
  // true if the cell belongs to the patch; columns · rows, false in the last column and row
  std::vector<char> cell;
  std::vector<SurfaceSample> samples;  // one per vertex
  std::vector<Eigen::Vector3i> triangles;
  int centre = -1;  // the vertex above the centre

  int node(int i, int j) const { return i + columns * j; }
};

// Returns the part of the surface that is connected to the point above `centre`. The centre becomes
// a node. A cell belongs to the patch if all four corners
//   - have surface and satisfy `desired`,
//   - lie within `half_width` of the centre in x and y,
//   - lie within `reach` of it along the surface, measured along edges and diagonals (up to 8 %
//     longer than the shortest path).
// Cells with an edge steeper than 80° are excluded: a height field cannot distinguish a wall from
// two surfaces one above the other.
//
// The surface is queried row by row in alternating direction, so that each point is near the
// previous one. Throws InputError if there is no surface above the centre, or no cell around it.
SurfacePatch make_patch(const SurfaceHeight& surface, const Eigen::Vector2d& centre, double spacing,
                        double half_width, double reach,
                        const std::function<bool(const Eigen::Vector2d&)>& desired);

// The patch without the cells of these triangles and their neighbours, and without what is then no
// longer connected to the centre. Returns nullopt where the centre has no cell left.
std::optional<SurfacePatch> without_triangles(const SurfacePatch& patch,
                                              const std::vector<int>& triangles);

}  // namespace impedraw
