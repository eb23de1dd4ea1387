// How the vertices of a built-in canvas are joined to triangles: in a grid, or in rings about a
// pole.
#pragma once

#include <functional>
#include <vector>

#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

// columns × rows cells, each cut in two along the same diagonal; the vertices are at(u, v), u and v
// from 0 to 1. Wound so that the normals point along ∂at/∂u × ∂at/∂v.
TriangleMesh grid_mesh(int columns, int rows,
                       const std::function<Eigen::Vector3d(double u, double v)>& at);

// The fewest cells of a length that are no longer than `edge`, at least one.
int cells(double length, double edge);

// Circles about the z axis, seen from above wound counter-clockwise.
struct Ring {
  double radius = 0.0;  // [m]
  double z = 0.0;       // [m]
  int count = 0;        // vertices, at least 3, the first at y = 0
};

// A pole on the z axis and the rings about it, from the inmost; neighbouring rings are stitched by
// always taking the shorter diagonal. Normals point up where the rings widen away from the pole.
TriangleMesh ring_mesh(double pole_z, const std::vector<Ring>& rings);

}  // namespace impedraw
