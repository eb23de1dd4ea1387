// Which triangles of a mesh are wound the wrong way.
#pragma once

#include <vector>

#include "impedraw/canvas/half_edges.h"
#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

struct Winding {
  std::vector<bool> wrong;   // a triangle: see mesh_check.h, wrong_winding
  std::vector<int> twisted;  // triangles that no winding suits, ascending
};

// `edges` are the mesh's; triangles are neighbours across edges with exactly two.
Winding find_winding(const TriangleMesh& mesh, const std::vector<HalfEdge>& edges);

}  // namespace impedraw
