#include "impedraw/canvas/mesh_patterns.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace impedraw {

TriangleMesh grid_mesh(int columns, int rows,
                       const std::function<Eigen::Vector3d(double u, double v)>& at) {
  TriangleMesh mesh;
  for (int row = 0; row <= rows; ++row) {
    for (int column = 0; column <= columns; ++column)
      mesh.vertices.push_back(at(double(column) / columns, double(row) / rows));
  }
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int a = row * (columns + 1) + column;
      const int b = a + columns + 1;
      mesh.triangles.emplace_back(a, a + 1, b + 1);
      mesh.triangles.emplace_back(a, b + 1, b);
    }
  }
  return mesh;
}

int cells(double length, double edge) {
  // The factor keeps 0.36/0.0015 at 240 despite rounding.
  return std::max(1, static_cast<int>(std::ceil(length / edge * (1.0 - 1e-12))));
}

TriangleMesh ring_mesh(double pole_z, const std::vector<Ring>& rings) {
  TriangleMesh mesh;
  mesh.vertices.emplace_back(0.0, 0.0, pole_z);
  int inner_first = 0;
  int inner_count = 1;
  for (const Ring& ring : rings) {
    const int outer_first = static_cast<int>(mesh.vertices.size());
    const int outer_count = ring.count;
    for (int i = 0; i < outer_count; ++i) {
      const double phi = 2.0 * std::numbers::pi * i / outer_count;
      mesh.vertices.emplace_back(ring.radius * std::cos(phi), ring.radius * std::sin(phi), ring.z);
    }
    // a fan about the pole
    const int inner_steps = inner_count == 1 ? 0 : inner_count;
    int i = 0;
    int j = 0;
    while (i < inner_steps || j < outer_count) {
      const int inner = inner_first + i % inner_count;
      const int outer = outer_first + j % outer_count;
      // The shorter of the two diagonals, compared as angles in whole numbers: (2 j +
      // 1)/outer_count ≤ (2 i + 1)/inner_count.
      const bool shorter =
          std::int64_t{2 * j + 1} * inner_count <= std::int64_t{2 * i + 1} * outer_count;
      const bool take_outer = j < outer_count && (i >= inner_steps || shorter);
      if (take_outer) {
        mesh.triangles.emplace_back(inner, outer, outer_first + (j + 1) % outer_count);
        ++j;
      } else {
        mesh.triangles.emplace_back(inner, outer, inner_first + (i + 1) % inner_count);
        ++i;
      }
    }
    inner_first = outer_first;
    inner_count = outer_count;
  }
  return mesh;
}

}  // namespace impedraw
