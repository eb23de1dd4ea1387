// Topology of a mesh: each triangle's neighbours, the surface's boundary, and the normals that
// determine the side of a closest point.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

// Vertices at exactly the same position count as one, so a mesh read as separate triangles still
// has neighbours.
//
// Each vertex has two normals. smooth_normal, interpolated over the triangles, weights each
// triangle by sin(angle)/(product of its two sides at the vertex), which is exact if the vertices
// lie on a sphere (Max, 1999). A vertex on a crease, an edge at which the surface turns by more
// than kCrease, has one for each side: the normal is not smoothed across creases. Otherwise that of
// a large flat face beside a sharp edge would lean by half of the edge's angle. side_normal weights
// by the angle. On an edge, the mean of the two
// face normals takes its place. The dot product with (p − closest point) then has the right sign
// everywhere around a closed surface (Bærentzen and Aanæs, 2005); a face's own normal would be
// wrong beside a sharp corner.
struct MeshTopology {
  static constexpr double kCrease = 0.7;  // [rad]
  struct Face {
    std::array<Eigen::Vector3d, 3> corner;  // [m]
    // unit; zero for a triangle without area or a thin one that is folded back, which joins its
    // neighbours but is skipped by queries
    Eigen::Vector3d normal;
    // triangle across the edge from corner i to corner i + 1; −1: boundary of the surface
    std::array<int, 3> neighbour;
    std::array<int, 3> vertex;   // index into side_normal and on_boundary
    std::array<int, 3> smooth;   // of each corner, index into smooth_normal
    std::array<bool, 3> crease;  // the edge from corner i to corner i + 1 is one
  };
  std::vector<Face> faces;
  std::vector<Eigen::Vector3d> smooth_normal;  // unit
  std::vector<Eigen::Vector3d> side_normal;    // unit
  std::vector<bool> on_boundary;               // the vertex lies on the surface's boundary
  std::vector<bool> on_crease;                 // the vertex lies on a crease
};

// Throws InputError naming the vertex or the triangle: nothing to draw on, a coordinate that is not
// finite, an index out of range, neighbours with opposite winding, or an edge with more than two
// triangles.
MeshTopology make_topology(const TriangleMesh& mesh);

// Checks only the first three of these conditions.
void require_valid(const TriangleMesh& mesh);

}  // namespace impedraw
