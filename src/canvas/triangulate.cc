
#include <fmt/format.h>
#include <Eigen/Geometry>

#include "impedraw/canvas/polygon_mesh.h"
#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr std::size_t kMostCorners = 2000;  // ear clipping takes up to n³ steps

double cross(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

// The outline projected along its mean normal, counter-clockwise.
std::vector<Vector2d> flattened(const std::vector<Vector3d>& vertices, std::span<const int> face) {
  const Vector3d& origin = vertices[face[0]];
  Vector3d normal = Vector3d::Zero();
  for (std::size_t i = 1; i + 1 < face.size(); ++i)
    normal += (vertices[face[i]] - origin).cross(vertices[face[i + 1]] - origin);
  const Vector3d u = normal.normalized().unitOrthogonal(), v = normal.normalized().cross(u);
  std::vector<Vector2d> outline;
  for (const int i : face)
    outline.emplace_back(u.dot(vertices[i] - origin), v.dot(vertices[i] - origin));
  return outline;
}

bool is_fan(const std::vector<Vector2d>& outline) {
  for (std::size_t i = 1; i + 1 < outline.size(); ++i) {
    if (!(cross(outline[0], outline[i], outline[i + 1]) > 0)) return false;
  }
  return true;
}

// True if the triangle at the k-th of the corners `left` lies inside the outline.
bool is_ear(const std::vector<Vector2d>& outline, const std::vector<int>& left, std::size_t k) {
  const std::size_t n = left.size();
  const Vector2d &a = outline[left[(k + n - 1) % n]], &b = outline[left[k]],
                 &c = outline[left[(k + 1) % n]];
  if (!(cross(a, b, c) > 0)) return false;
  for (const int i : left) {
    const Vector2d& p = outline[i];
    if (p == a || p == b || p == c) continue;
    if (cross(a, b, p) >= 0 && cross(b, c, p) >= 0 && cross(c, a, p) >= 0) return false;
  }
  return true;
}

}  // namespace

std::vector<Vector3i> triangulate(const PolygonMesh& mesh, const std::string& name) {
  std::vector<Vector3i> triangles;
  triangles.reserve(mesh.corners.size() - 2 * mesh.faces());
  for (std::size_t f = 0; f < mesh.faces(); ++f) {
    const std::span<const int> face = mesh.face(f);
    std::vector<int> left;  // corners not cut off yet
    if (face.size() > 3) {
      const std::vector<Vector2d> outline = flattened(mesh.vertices, face);
      if (!is_fan(outline)) {
        if (face.size() > kMostCorners) {
          throw InputError(fmt::format("{}: face {} has {} corners and is not convex, at most {}",
                                       name, f, face.size(), kMostCorners));
        }
        for (std::size_t i = 0; i < face.size(); ++i) left.push_back(static_cast<int>(i));
        std::size_t passed = 0;  // corners since the last ear; if all, no ear exists
        for (std::size_t k = 1; left.size() > 3 && passed < left.size();) {
          k %= left.size();
          if (!is_ear(outline, left, k)) {
            ++k, ++passed;
            continue;
          }
          const std::size_t n = left.size();
          triangles.emplace_back(face[left[(k + n - 1) % n]], face[left[k]],
                                 face[left[(k + 1) % n]]);
          left.erase(left.begin() + static_cast<std::ptrdiff_t>(k));
          passed = 0;
        }
      }
    }
    const auto corner = [&](std::size_t i) { return face[left.empty() ? i : left[i]]; };
    const std::size_t rest = left.empty() ? face.size() : left.size();
    for (std::size_t i = 1; i + 1 < rest; ++i)
      triangles.emplace_back(corner(0), corner(i), corner(i + 1));
  }
  return triangles;
}

}  // namespace impedraw
