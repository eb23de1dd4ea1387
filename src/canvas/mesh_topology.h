// Topology of a mesh: each triangle's neighbours, the surface's boundary, and the normals that
// determine the side of a closest point.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

// Union and find over the numbers 0 … size − 1.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) parent_.push_back(static_cast<int>(i));
  }
  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(int a, int b) { parent_[find(a)] = find(b); }

 private:
  std::vector<int> parent_;
};

// The sides of triangles, sorted so that those on one edge are adjacent.
struct HalfEdge {
  int low, high;   // vertices
  int face, side;  // side i runs from corner i to corner i + 1
  bool forward;    // the triangle runs from low to high
};

// The half-edges of every triangle whose corners are three different vertices. Vertices are
// numbered 0 … vertices − 1. Sorted by low, high, face.
std::vector<HalfEdge> half_edges(const std::vector<Eigen::Vector3i>& triangles, int vertices);

// Calls visit(first, last) with the half-edges [first, last) of each edge.
template <class Visit>
void for_each_edge(const std::vector<HalfEdge>& edges, Visit&& visit) {
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high)
      ++end;
    visit(edges.data() + i, edges.data() + end);
    i = end;
  }
}

// Vertices at exactly the same position count as one, so a mesh read as separate triangles still
// has neighbours.
//
// Each vertex has two normals. smooth_normal, interpolated over the triangles, weights each
// triangle by sin(angle)/(product of its two sides at the vertex), which is exact if the vertices
// lie on a sphere (Max, 1999). A vertex on a crease, an edge at which the surface turns by more
// than kCrease, has one for each side: the normal is not smoothed across creases. Otherwise that of
// a large flat face beside a sharp edge would lean by half of the edge's angle. side_normal weights
// by the angle. On an edge, the mean of the two face normals takes its place. The dot product with
// (p − closest point) then has the right sign everywhere around a closed surface (Bærentzen and
// Aanæs, 2005); a face's own normal would be wrong beside a sharp corner.
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
