// The side of an open mesh that faces somebody who looks at it.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

// Turns each open part (its triangles share vertices, and some edge has one triangle) that shows
// its back to somebody who looks along −z: of a part's topmost triangles, one in each cell of a
// grid across z, more than three quarters face away, by the areas that are seen. A closed part has
// an inside, and stays. Returns the number of triangles turned.
int turn_parts_seen_from_behind(TriangleMesh* mesh, const Eigen::Vector3d& z);

// The parts of a mesh that lie outside of a box. Triangles across its faces are cut there.

// Each triangle with its own vertices; fronts stay fronts.
TriangleMesh outside_box(const TriangleMesh& mesh, const Eigen::AlignedBox3d& box);

}  // namespace impedraw
