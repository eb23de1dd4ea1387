#include "impedraw/canvas/half_edges.h"

#include <algorithm>
#include <tuple>

namespace impedraw {

std::vector<HalfEdge> half_edges(const std::vector<Eigen::Vector3i>& triangles, int vertices) {
  const auto collapsed = [](const Eigen::Vector3i& t) {
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
  };
  // Bucket by the lower vertex in one pass, as in a counting sort. Millions of edges are then
  // sorted a few at a time.
  std::vector<std::size_t> start(vertices + 1, 0);
  for (const auto& t : triangles) {
    if (collapsed(t)) continue;
    for (int side = 0; side < 3; ++side) ++start[std::min(t[side], t[(side + 1) % 3]) + 1];
  }
  for (int v = 0; v < vertices; ++v) start[v + 1] += start[v];
  std::vector<HalfEdge> edges(start[vertices]);
  std::vector<std::size_t> next(start.begin(), start.end() - 1);
  for (int f = 0; f < static_cast<int>(triangles.size()); ++f) {
    const auto& t = triangles[f];
    if (collapsed(t)) continue;
    for (int side = 0; side < 3; ++side) {
      const int a = t[side], b = t[(side + 1) % 3];
      edges[next[std::min(a, b)]++] = {std::min(a, b), std::max(a, b), f, side, a < b};
    }
  }
  const auto before = [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.high, a.face) < std::tie(b.high, b.face);
  };
  for (int v = 0; v < vertices; ++v)
    std::sort(edges.begin() + start[v], edges.begin() + start[v + 1], before);
  return edges;
}

}  // namespace impedraw
