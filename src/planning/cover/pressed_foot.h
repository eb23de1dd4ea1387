// A round footprint's foam on a surface, pressed by a disc whose plane is that of the places under
// it.
//
//   z    = o + b·(x, y)            plane by least squares, about the centre
//   d    = δ + (z_place − z) n_z   depth of a place in the foam, n: normal of the plane
//   p/p̄  = max(0, d) / mean of max(0, d) under the disc
#pragma once

#include <algorithm>
#include <vector>

#include <Eigen/Core>

#include "impedraw/planning/cover/surface_grid.h"

namespace impedraw {

struct Footprint {
  double radius = 0.015;      // [m]
  double compression = 1e-3;  // δ, of the foam under the force asked for [m]
  double thickness = 0.01;    // of the foam [m]
};

class PressedFoot {
 public:
  PressedFoot(const SurfaceGrid& grid, const Eigen::Vector3d& centre, const Footprint& foot);
  // d: < 0 where the foam does not touch [m].
  double depth(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d d = p - centre_;
    return compression_ + (d.z() - plane_.dot(Eigen::Vector3d(1.0, d.x(), d.y()))) * along_normal_;
  }
  // From the disc's axis [m].
  double off_axis(const Eigen::Vector3d& p) const {
    return (p - centre_ - Eigen::Vector3d(0.0, 0.0, plane_.x())).cross(normal()).norm();
  }
  double pressure(const Eigen::Vector3d& p) const { return std::max(0.0, depth(p)) / mean_; }
  Eigen::Vector3d normal() const {  // of the plane, upward
    return along_normal_ * Eigen::Vector3d(-plane_.y(), -plane_.z(), 1.0);
  }

 private:
  friend class PressedFeet;
  PressedFoot() = default;
  void set_plane(const Eigen::Vector3d& plane);

  Eigen::Vector3d centre_, plane_;  // plane: o, b
  double compression_ = 0.0, along_normal_ = 1.0, mean_ = 1.0;
};

// The same everywhere on a grid, fitted once at each vertex and bilinear between them.
class PressedFeet {
 public:
  PressedFeet() = default;
  PressedFeet(const SurfaceGrid& grid, const Footprint& foot);
  const Footprint& foot() const { return foot_; }
  // `grid`: the same.
  PressedFoot at(const SurfaceGrid& grid, const Eigen::Vector2d& p) const;

 private:
  Footprint foot_;
  std::vector<double> offset_, slope_x_, slope_y_, mean_;
};

// The surface, with the normals of the planes under the footprint: a disc that lies so presses
// evenly, where the surface's own normal in the disc's middle would have it lean.
SurfaceHeight with_normals_of(const PressedFeet& feet, const SurfaceGrid& grid,
                              SurfaceHeight surface);

}  // namespace impedraw
