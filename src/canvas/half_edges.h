// The sides of triangles, sorted so that those on one edge are adjacent.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

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

}  // namespace impedraw
