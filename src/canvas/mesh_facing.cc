#include "impedraw/canvas/mesh_facing.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "impedraw/canvas/disjoint_sets.h"
#include "impedraw/canvas/half_edges.h"

namespace impedraw {

int turn_parts_seen_from_behind(TriangleMesh* mesh, const Eigen::Vector3d& z) {
  constexpr int kCells = 128;  // along each side of the grid
  constexpr double kMostly = 0.75;
  const Eigen::Vector3d x = z.unitOrthogonal(), y = z.cross(x);
  const int vertices = static_cast<int>(mesh->vertices.size());
  DisjointSets parts(mesh->vertices.size());
  for (const Eigen::Vector3i& t : mesh->triangles)
    for (int i = 1; i < 3; ++i) parts.join(t[0], t[i]);
  std::vector<bool> open(mesh->vertices.size(), false);  // of each part
  const std::vector<HalfEdge> edges = half_edges(mesh->triangles, vertices);
  for_each_edge(edges, [&](const HalfEdge* first, const HalfEdge* last) {
    if (last - first == 1) open[parts.find(first->low)] = true;
  });
  if (std::find(open.begin(), open.end(), true) == open.end()) return 0;

  Eigen::AlignedBox2d box;
  for (const Eigen::Vector3d& p : mesh->vertices) box.extend(Eigen::Vector2d(x.dot(p), y.dot(p)));
  const Eigen::Vector2d cell = (box.sizes() / kCells).cwiseMax(1e-9);
  struct Top {
    double height = -std::numeric_limits<double>::infinity();
    int triangle = -1;
  };
  std::vector<Top> tops(kCells * kCells);
  for (int f = 0; f < static_cast<int>(mesh->triangles.size()); ++f) {
    const Eigen::Vector3i& t = mesh->triangles[f];
    const Eigen::Vector3d middle =
        (mesh->vertices[t[0]] + mesh->vertices[t[1]] + mesh->vertices[t[2]]) / 3.0;
    const Eigen::Vector2d at =
        (Eigen::Vector2d(x.dot(middle), y.dot(middle)) - box.min()).cwiseQuotient(cell);
    const int i = std::clamp(static_cast<int>(at.x()), 0, kCells - 1),
              j = std::clamp(static_cast<int>(at.y()), 0, kCells - 1);
    Top& top = tops[kCells * i + j];
    if (z.dot(middle) > top.height) top = {z.dot(middle), f};
  }
  std::vector<double> front(mesh->vertices.size(), 0.0), back = front;  // of each part [m²]
  for (const Top& top : tops) {
    if (top.triangle < 0) continue;
    const Eigen::Vector3i& t = mesh->triangles[top.triangle];
    const Eigen::Vector3d& p = mesh->vertices[t[0]];
    const double facing = z.dot((mesh->vertices[t[1]] - p).cross(mesh->vertices[t[2]] - p)) / 2.0;
    (facing > 0.0 ? front : back)[parts.find(t[0])] += std::abs(facing);
  }
  int turned = 0;
  for (Eigen::Vector3i& t : mesh->triangles) {
    const int part = parts.find(t[0]);
    if (!open[part] || back[part] <= kMostly * (front[part] + back[part])) continue;
    std::swap(t[1], t[2]);
    ++turned;
  }
  return turned;
}

}  // namespace impedraw
