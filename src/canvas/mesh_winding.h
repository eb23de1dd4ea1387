// Finds the triangles of a mesh that have the wrong winding.
#pragma once

#include <vector>

#include "impedraw/canvas/half_edges.h"
#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

struct Winding {
  std::vector<bool> wrong;   // per triangle: see wrong_winding in mesh_check.h
  std::vector<int> twisted;  // triangles without a consistent winding, ascending
};

// `edges` are the mesh's half-edges. Triangles are neighbours across edges that exactly two share.
Winding find_winding(const TriangleMesh& mesh, const std::vector<HalfEdge>& edges);

}  // namespace impedraw
