// What lies around each triangle: neighbours, edges of the surface, and normals that give a closest
// point its side.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

// Vertices at exactly the same place count as one, so that a mesh read as loose triangles still has
// its neighbours.
//
// Two normals a vertex. smooth_normal, interpolated over the triangles, weights each by
// sin(angle)/(product of its two sides at the vertex), which is exact where the vertices lie on a
// sphere (Max, 1999). side_normal weights by the angle: with the mean of two face normals on an
// edge, its dot product with (p − closest point) has the right sign everywhere around a closed
// surface (Bærentzen and Aanæs, 2005), where a face's own normal would be wrong beside a sharp
// corner.
struct MeshTopology {
  struct Face {
    std::array<Eigen::Vector3d, 3> corner;  // [m]
    Eigen::Vector3d
        // unit; zero for a triangle without area: it joins its neighbours, but queries pass over it
        normal;
    std::array<int, 3>
        // triangle across the edge from corner i to corner i + 1; −1: an edge of the surface
        neighbour;
    std::array<int, 3> vertex;  // into the three below
  };
  std::vector<Face> faces;
  std::vector<Eigen::Vector3d> smooth_normal;  // unit
  std::vector<Eigen::Vector3d> side_normal;    // unit
  std::vector<bool> on_boundary;               // the vertex belongs to an edge of the surface
};

// Throws InputError, naming the vertex or the triangle: nothing to draw on, a coordinate that is
// not finite, an index out of range, neighbours wound against each other, an edge with more than
// two triangles.
MeshTopology make_topology(const TriangleMesh& mesh);

// The first three of these.
void require_valid(const TriangleMesh& mesh);

}  // namespace impedraw
