// The drawing surface as exact triangles: closest points, sides, normals and ray intersections.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

// The point of the canvas closest to a query point p.
struct SurfacePoint {
  Eigen::Vector3d p_W;  // [m]
  // unit, outward; interpolated between the vertices' normals, so continuous along the surface but
  // at creases (mesh_topology.h). Closest to p on one: from there to p.
  Eigen::Vector3d n_W;
  double distance = 0.0;  // ±|p − p_W| [m]; > 0 on the drawing side, < 0 behind it
  // index into mesh().triangles; −1 only if the query is not finite (distance is then NaN)
  int triangle = -1;
  // the closest point lies on the surface's boundary: p is above the rim or beyond it
  bool on_edge = false;
};

// The first intersection of the ray origin + t direction, t ≥ 0, with the canvas, from either side.
struct RayHit {
  double t = 0.0;       // in multiples of the direction's length
  Eigen::Vector3d p_W;  // [m]
  Eigen::Vector3d n_W;  // unit, outward; interpolated as above
  int triangle = -1;
};

// Embree finds candidates in single precision. Closest points and intersections are then computed
// in double precision on the exact triangles. Among equally close triangles the lowest index wins,
// so results do not depend on how the search tree was built.
//
// Queries are const, thread-safe, and do not allocate.
class Canvas {
 public:
  // Throws InputError naming the vertex or the triangle; see make_topology().
  explicit Canvas(TriangleMesh mesh);
  ~Canvas();
  Canvas(Canvas&&) noexcept;
  Canvas& operator=(Canvas&&) noexcept;

  SurfacePoint closest(const Eigen::Vector3d& p_W) const noexcept;

  // As above, but nullopt if the canvas is further away than max_distance [m]. Much faster for a
  // small max_distance: prefer it in loops.
  std::optional<SurfacePoint> closest(const Eigen::Vector3d& p_W,
                                      double max_distance) const noexcept;

  // The same point, and after it every other place within `reach` of p at which the distance from p
  // has a local minimum, nearest first. Two faces that meet at a concave edge have one each.
  // Returns how many `found` holds: the nearest ones, if there are more than it has room for; 0 if
  // the canvas is further away than max_distance [m].
  int closest_places(const Eigen::Vector3d& p_W, double reach, double max_distance,
                     std::span<SurfacePoint> found) const noexcept;

  // The direction need not have unit length.
  std::optional<RayHit> ray(const Eigen::Vector3d& origin_W,
                            const Eigen::Vector3d& direction_W) const noexcept;

  // Distances of the first intersections along unit directions from one origin [m], infinity where
  // there is none: the same numbers as ray(), in packets, which neighbouring directions make fast.
  void rays(const Eigen::Vector3d& origin_W, std::span<const Eigen::Vector3d> directions_W,
            std::span<double> distances) const noexcept;

  const TriangleMesh& mesh() const noexcept;
  const Eigen::AlignedBox3d& bounds() const noexcept;  // of the vertices [m], W

 private:
  struct Search;
  std::unique_ptr<Search> search_;
};

}  // namespace impedraw
