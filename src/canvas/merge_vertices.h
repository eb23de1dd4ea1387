// Merges vertices that nearly coincide.
#pragma once

#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

// Replaces each vertex that a triangle uses by the first one, in the triangles' order, within
// `tolerance` [m] of it. Drops unused vertices. Keeps the number and order of the triangles.
// Precondition: finite coordinates, indices in range, tolerance ≥ 0.
TriangleMesh merge_vertices(const TriangleMesh& mesh, double tolerance);

}  // namespace impedraw
