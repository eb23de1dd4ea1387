// What is wrong with a mesh that somebody else made, and the mesh that is left when it is repaired.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

// Kinds, in the order in which they are looked for, with vertices merged at 1e-6 of the bounding
// box's diagonal:
//   too_large, too_small   the longest side of the bounding box is above 5 m or below 1 mm: mostly
//                          a wrong unit
//   degenerate_triangle    two corners are one vertex, or it is thinner than the weld. Repaired:
//                          left
//                          out, unless its neighbours would then
//                          have a gap between them; queries pass over it all the same
//   duplicate_triangle     has the vertices of an earlier one, in whatever order. Repaired: left
//                          out
//   non_manifold_edge      more than two triangles share it; `first` is the lowest of them
//   not_orientable         no winding suits it and all of its neighbours, as on a Möbius strip
//   wrong_winding          against most of its connected patch; or a closed patch, all of it, is
//                          inside out, unless it lies within a larger
//                          one, whose cavity it then is. Repaired: turned
struct MeshFault {
  std::string kind;
  std::size_t count = 0;
  // the lowest triangle it holds for, from 0, as counted before anything was left out
  int first = 0;
  bool repaired = false;  // if not, the mesh cannot be drawn on
  std::string message;    // one line
};

struct CheckedMesh {
  TriangleMesh mesh;  // merged and repaired
  std::size_t given_triangles = 0;
  Eigen::AlignedBox3d bounds;  // of all triangles given [m]
  double weld = 0.0;           // [m]
  std::vector<MeshFault> faults;
  bool closed = false;  // every edge has exactly two triangles
  int components = 0;   // parts that share no vertex
};

// Throws InputError, naming the vertex or the triangle, where there is nothing to check: no
// triangle, none with an area, a coordinate that is not finite, an index out of range.
CheckedMesh check_mesh(const TriangleMesh& mesh);

// The triangle of that mesh is thinner than its weld: its normal says nothing.
bool is_thin(const CheckedMesh& mesh, const Eigen::Vector3i& triangle);

// read_mesh and check_mesh; messages are opened by the file's name.
CheckedMesh load_mesh(const std::filesystem::path& file, double unit);

// Throws InputError with the first fault that was not repaired.
void require_drawable(const CheckedMesh& mesh, const std::string& name);

}  // namespace impedraw
