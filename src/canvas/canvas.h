// The surface that is drawn on, as exact triangles: closest point, side, normal, and where a ray
// meets it.
#pragma once

#include <memory>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

// The canvas's point closest to a query point p.
struct SurfacePoint {
  Eigen::Vector3d p_W;  // [m]
  Eigen::Vector3d
      // unit; outward, interpolated between the vertices' normals, so continuous along the surface
      n_W;
  double distance = 0.0;  // |p − p_W| [m], > 0 on the side that is drawn on, < 0 behind it
  // into mesh().triangles; −1 only for a query that is not finite (distance is then NaN)
  int triangle = -1;
  // the closest point lies on an edge of the surface: p stands over the rim or beyond it
  bool on_edge = false;
};

// Where the ray origin + t direction, t ≥ 0, first meets the canvas, from either side.
struct RayHit {
  double t = 0.0;       // in lengths of the direction
  Eigen::Vector3d p_W;  // [m]
  Eigen::Vector3d n_W;  // unit; outward, interpolated as above
  int triangle = -1;
};

// Embree finds the candidates in single precision; closest points and intersections are then
// computed in double precision, on the exact triangles. Of triangles equally close the lowest index
// is taken, so that answers do not depend on how the search tree was built.
//
// Queries are const, may run in any number of threads at once, and allocate nothing.
class Canvas {
 public:
  explicit Canvas(
      TriangleMesh mesh);  // throws InputError naming the vertex or the triangle, see make_topology
  ~Canvas();
  Canvas(Canvas&&) noexcept;
  Canvas& operator=(Canvas&&) noexcept;

  SurfacePoint closest(const Eigen::Vector3d& p_W) const noexcept;

  // As above, nothing where the canvas is further off than max_distance [m]. Much faster where that
  // is small: give it in a loop.
  std::optional<SurfacePoint> closest(const Eigen::Vector3d& p_W,
                                      double max_distance) const noexcept;

  // The direction need not be of unit length.
  std::optional<RayHit> ray(const Eigen::Vector3d& origin_W,
                            const Eigen::Vector3d& direction_W) const noexcept;

  const TriangleMesh& mesh() const noexcept;
  const Eigen::AlignedBox3d& bounds() const noexcept;  // of the vertices [m], W

 private:
  struct Search;
  std::unique_ptr<Search> search_;
};

}  // namespace impedraw
