#include "impedraw/canvas/mesh_facing.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "impedraw/canvas/mesh_topology.h"

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

TriangleMesh outside_box(const TriangleMesh& mesh, const Eigen::AlignedBox3d& box) {
  using Polygon = std::vector<Eigen::Vector3d>;
  TriangleMesh out;
  const auto add_fan = [&out](const Polygon& p) {
    for (std::size_t i = 1; i + 1 < p.size(); ++i) {
      if ((p[i] - p[0]).cross(p[i + 1] - p[0]).isZero(0.0)) continue;
      const int first = static_cast<int>(out.vertices.size());
      out.vertices.insert(out.vertices.end(), {p[0], p[i], p[i + 1]});
      out.triangles.push_back({first, first + 1, first + 2});
    }
  };
  Polygon inside, within, beyond;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    inside = {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
    if (box.contains(inside[0]) && box.contains(inside[1]) && box.contains(inside[2])) continue;
    // A part beyond one of the box's planes is outside; the rest goes on to the next.
    for (int plane = 0; plane < 6 && !inside.empty(); ++plane) {
      const int axis = plane / 2;
      const double sign = plane % 2 == 0 ? 1.0 : -1.0;
      const double face = plane % 2 == 0 ? box.max()[axis] : box.min()[axis];
      within.clear();
      beyond.clear();
      for (std::size_t i = 0; i < inside.size(); ++i) {
        const Eigen::Vector3d &a = inside[i], &b = inside[(i + 1) % inside.size()];
        const double past_a = sign * (a[axis] - face), past_b = sign * (b[axis] - face);
        (past_a > 0.0 ? beyond : within).push_back(a);
        if ((past_a > 0.0) == (past_b > 0.0)) continue;
        const Eigen::Vector3d cut = a + past_a / (past_a - past_b) * (b - a);
        within.push_back(cut);
        beyond.push_back(cut);
      }
      add_fan(beyond);
      inside.swap(within);
    }
  }
  return out;
}

}  // namespace impedraw
