// Repairs of an external mesh: triangles of the wrong winding, vertices that stand twice.
#pragma once

#include <vector>

#include "impedraw/canvas/mesh_topology.h"
#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

struct Winding {
  std::vector<bool> wrong;   // per triangle: see wrong_winding in mesh_check.h
  std::vector<int> twisted;  // triangles without a consistent winding, ascending
};

// `edges` are the mesh's half-edges. Triangles are neighbours across edges that exactly two share.
Winding find_winding(const TriangleMesh& mesh, const std::vector<HalfEdge>& edges);

// Replaces each vertex that a triangle uses by the first one, in the triangles' order, within
// `tolerance` [m] of it. Drops unused vertices. Keeps the number and order of the triangles.
// Precondition: finite coordinates, indices in range, tolerance ≥ 0.
TriangleMesh merge_vertices(const TriangleMesh& mesh, double tolerance);

}  // namespace impedraw
