// Triangulates the vertices of a built-in canvas in a grid, or in rings about a pole.
#pragma once

#include <functional>
#include <vector>

#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

// A grid of columns × rows cells, each cut along the same diagonal. Vertices are at(u, v), with u
// and v from 0 to 1. Normals point along ∂at/∂u × ∂at/∂v.
TriangleMesh grid_mesh(int columns, int rows,
                       const std::function<Eigen::Vector3d(double u, double v)>& at);

// The smallest number of equal cells, each at most `edge` long, that make up `length`; at least
// one.
int cells(double length, double edge);

// A circle of vertices about the z axis, counter-clockwise seen from above.
struct Ring {
  double radius = 0.0;  // [m]
  double z = 0.0;       // [m]
  int count = 0;        // vertices, at least 3, the first at y = 0
};

// A pole on the z axis and the rings about it, innermost first. Neighbouring rings are stitched
// along the shorter diagonals. Normals point up if the rings widen away from the pole.
TriangleMesh ring_mesh(double pole_z, const std::vector<Ring>& rings);

}  // namespace impedraw
