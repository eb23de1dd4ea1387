// The parts of a mesh that lie outside of a box. Triangles across its faces are cut there.
#pragma once

#include <Eigen/Geometry>

#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

// Each triangle with its own vertices; fronts stay fronts.
TriangleMesh outside_box(const TriangleMesh& mesh, const Eigen::AlignedBox3d& box);

}  // namespace impedraw
