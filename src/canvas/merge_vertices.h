// Vertices at nearly the same place made one.
#pragma once

#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

// Every vertex that a triangle names becomes the first one, in the triangles' order, within
// `tolerance` [m] of it; vertices that no triangle names are left out. Triangles keep their number
// and order. Precondition: finite coordinates, indices in range, tolerance ≥ 0.
TriangleMesh merge_vertices(const TriangleMesh& mesh, double tolerance);

}  // namespace impedraw
