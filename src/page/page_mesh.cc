#include "impedraw/page/page_mesh.h"

#include <meshoptimizer.h>
#include <Eigen/Geometry>

namespace impedraw {
namespace {

using Eigen::Vector3d;

Vector3d area_normal(const std::vector<Vector3d>& vertices, unsigned a, unsigned b, unsigned c) {
  return (vertices[b] - vertices[a]).cross(vertices[c] - vertices[a]);
}

// Collapsed edges leave triangles without an area, and slivers that fold over their neighbours:
// they face away from the surface as it was at their corners, and are turned over. (Without them
// there would be pinholes.)
std::vector<unsigned> unfolded(const std::vector<Vector3d>& vertices,
                               const std::vector<unsigned>& whole,
                               const std::vector<unsigned>& thinned) {
  std::vector<Vector3d> normals(vertices.size(), Vector3d::Zero());
  for (std::size_t i = 0; i + 2 < whole.size(); i += 3) {
    const Vector3d n = area_normal(vertices, whole[i], whole[i + 1], whole[i + 2]);
    for (int k = 0; k < 3; ++k) normals[whole[i + k]] += n;
  }
  std::vector<unsigned> kept;
  for (std::size_t i = 0; i + 2 < thinned.size(); i += 3) {
    const unsigned a = thinned[i], b = thinned[i + 1], c = thinned[i + 2];
    const Vector3d around =
        normals[a].normalized() + normals[b].normalized() + normals[c].normalized();
    const double faces = area_normal(vertices, a, b, c).dot(around);
    if (faces > 0.0) kept.insert(kept.end(), {a, b, c});
    if (faces < 0.0) kept.insert(kept.end(), {a, c, b});
  }
  return kept;
}

constexpr std::size_t kStride = 3 * sizeof(float);

std::vector<float> floats_of(const std::vector<Vector3d>& vertices) {
  std::vector<float> positions;
  positions.reserve(3 * vertices.size());
  for (const Vector3d& v : vertices)
    for (int k = 0; k < 3; ++k) positions.push_back(static_cast<float>(v[k]));
  return positions;
}

std::vector<unsigned> corners_of(const std::vector<Eigen::Vector3i>& triangles) {
  std::vector<unsigned> corners;
  corners.reserve(3 * triangles.size());
  for (const Eigen::Vector3i& triangle : triangles)
    for (int k = 0; k < 3; ++k) corners.push_back(static_cast<unsigned>(triangle[k]));
  return corners;
}

// Leaves out the vertices that no triangle uses.
PageMesh compacted(const std::vector<Vector3d>& vertices, const std::vector<unsigned>& corners) {
  PageMesh mesh;
  std::vector<int> place(vertices.size(), -1);
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
    Eigen::Vector3i triangle;
    for (int k = 0; k < 3; ++k) {
      int& to = place[corners[i + k]];
      if (to < 0) {
        to = static_cast<int>(mesh.vertices.size());
        mesh.vertices.push_back(vertices[corners[i + k]]);
      }
      triangle[k] = to;
    }
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

std::vector<Eigen::Vector3i> coarse_triangles(const PageMesh& mesh, double off) {
  const std::vector<unsigned> corners = corners_of(mesh.triangles);
  const std::vector<float> positions = floats_of(mesh.vertices);
  const double scale = meshopt_simplifyScale(positions.data(), mesh.vertices.size(), kStride);
  if (corners.empty() || !(scale > 0.0)) return {};
  std::vector<unsigned> fewer(corners.size());
  fewer.resize(meshopt_simplify(fewer.data(), corners.data(), corners.size(), positions.data(),
                                mesh.vertices.size(), kStride, 0, static_cast<float>(off / scale),
                                meshopt_SimplifyLockBorder, nullptr));
  fewer = unfolded(mesh.vertices, corners, fewer);
  if (fewer.empty() || 3 * fewer.size() > 2 * corners.size()) return {};
  meshopt_optimizeVertexCache(fewer.data(), fewer.data(), fewer.size(), mesh.vertices.size());
  std::vector<Eigen::Vector3i> coarse;
  for (std::size_t i = 0; i + 2 < fewer.size(); i += 3)
    coarse.push_back(Eigen::Matrix<unsigned, 3, 1>(fewer.data() + i).cast<int>());
  return coarse;
}

}  // namespace

PageMesh page_mesh(const std::vector<Eigen::Vector3d>& vertices,
                   const std::vector<Eigen::Vector3i>& triangles, std::size_t most, double off) {
  std::vector<unsigned> corners = corners_of(triangles);
  double error = 0.0;
  if (triangles.size() > most) {
    const std::vector<float> positions = floats_of(vertices);
    constexpr float kAnyError = 1e-2f;  // of the mesh's extent
    const double scale = meshopt_simplifyScale(positions.data(), vertices.size(), kStride);
    std::vector<unsigned> fewer(corners.size());
    float relative = 0.0f;
    std::size_t n = meshopt_simplify(fewer.data(), corners.data(), corners.size(), positions.data(),
                                     vertices.size(), kStride, 3 * most, kAnyError,
                                     meshopt_SimplifyLockBorder, &relative);
    if (n > 6 * most)
      n = meshopt_simplifySloppy(fewer.data(), corners.data(), corners.size(), positions.data(),
                                 vertices.size(), kStride, 3 * most, 1.0f, &relative);
    fewer.resize(n);
    corners = unfolded(vertices, corners, fewer);
    error = relative * scale;
  }
  // The order of triangles that deflates best is also the one that a graphics card likes best.
  if (!corners.empty())
    meshopt_optimizeVertexCache(corners.data(), corners.data(), corners.size(), vertices.size());
  PageMesh mesh = compacted(vertices, corners);
  mesh.of = triangles.size();
  mesh.error = error;
  mesh.coarse = coarse_triangles(mesh, off);
  return mesh;
}

PageMesh canvas_mesh(const std::vector<Eigen::Vector3d>& vertices,
                     const std::vector<Eigen::Vector3i>& triangles) {
  return page_mesh(vertices, triangles, 16000, 8e-5);  // as coarseOff of web/src/scene.ts
}

}  // namespace impedraw
