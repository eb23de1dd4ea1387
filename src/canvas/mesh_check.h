// Finds the faults of an external mesh and repairs those that can be repaired.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "impedraw/canvas/mesh_file.h"
#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

// Kinds of faults, in the order in which they are checked, with vertices merged at 1e-6 of the
// bounding box's diagonal:
//   too_large, too_small   the longest side of the bounding box is above 5 m or below 1 mm: usually
//                          a wrong unit
//   degenerate_triangle    two corners are one vertex, or it is thinner than the weld. Repaired:
//                          left out, unless that would leave a gap between its neighbours; queries
//                          skip it in any case
//   duplicate_triangle     has the vertices of another one, in any order. Repaired: left out, and
//                          both of two that are a fold of a surface which closes without them
//   non_manifold_edge      more than two triangles share an edge; `first` is the lowest of them.
//                          Repaired: two and two go on into each other, those that are wound alike
//                          and of one body, or turn least; the surfaces are separated there, by a
//                          nanometre. Where they are of one body all the same, the two that turn
//                          least stay, and the others are cut loose from all of their neighbours
//   not_orientable         no winding agrees with all of its neighbours, as on a Möbius strip.
//                          Repaired: cut loose, if they are at most one in a thousand
//   wrong_winding          wound against most of its connected patch; or a whole closed patch is
//                          inside out, unless it lies within a larger one and is its cavity.
//                          Repaired: reversed
struct MeshFault {
  std::string kind;
  std::size_t count = 0;
  // lowest triangle affected, from 0, counted before anything was left out
  int first = 0;
  bool repaired = false;  // if false, the mesh cannot be drawn on
  std::string message;    // one line
};

struct CheckedMesh {
  TriangleMesh mesh;  // merged and repaired
  std::size_t given_triangles = 0;
  Eigen::AlignedBox3d bounds;  // of all input triangles [m]
  double weld = 0.0;           // [m]
  std::vector<MeshFault> faults;
  std::vector<std::string> warnings;  // of reading it, one line each
  bool closed = false;                // every edge has exactly two triangles
  int components = 0;                 // parts that share no vertex
};

// Throws InputError naming the vertex or the triangle if there is nothing to check: no triangle,
// none with an area, a coordinate that is not finite, or an index out of range.
CheckedMesh check_mesh(const TriangleMesh& mesh);

// True if the triangle is thinner than the mesh's weld, so that its normal is meaningless.
bool is_thin(const CheckedMesh& mesh, const Eigen::Vector3i& triangle);

// Calls read_mesh() and check_mesh(). Messages begin with the file's name, warnings do not. Where
// the file does not say which axis is up, a warning says that the mesh seems to stand upright as y;
// another, that it lies so far from its origin that it is to be recentred.
CheckedMesh load_mesh(const std::filesystem::path& file, const MeshReading& reading);

// Throws InputError with the first fault that was not repaired.
void require_drawable(const CheckedMesh& mesh, const std::string& name);

}  // namespace impedraw
