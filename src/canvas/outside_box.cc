#include "impedraw/canvas/outside_box.h"

#include <vector>

namespace impedraw {

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
    // What is beyond one of the box's planes is outside; the rest goes on to the next.
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
