// The workpiece of the force benchmark: three shapes about a middle p. All of them face upwards.
//
//   bowl  the lowest part of a sphere of 0.3 m, as the standard bowl; p is its lowest point
//   flat  a plane through p
//   roof  two planes that fall by 10° to either side of an edge along y through p
//
// A controller believes it to be where the rigid motion X_WB about p puts it.
#pragma once

#include <string_view>

#include <Eigen/Core>

#include "impedraw/canvas/triangle_mesh.h"
#include "impedraw/common/pose.h"
#include "impedraw/control/surface_estimate.h"

namespace impedraw {

struct Workpiece {
  enum class Shape { bowl, flat, roof };
  static constexpr std::string_view kNames[] = {"bowl", "flat", "roof"};

  Shape shape = Shape::bowl;
  Eigen::Vector3d p_W{0.60, 0.0, 0.10};  // the middle [m]
  Pose X_WB;                             // displacement of the belief from the truth, about p_W

  // The true one. The bowl's has chords of 1.5 mm, 1.9 µm off the sphere.
  TriangleMesh mesh() const;
  // As believed: nearest surface below and distance, and the point over (x, y) from the middle. The
  // roof's edge is believed to be round within 2 mm: an estimate from points cannot do better.
  SurfaceEstimate estimate(const Eigen::Vector3d& p_W) const noexcept;
  struct Place {
    Eigen::Vector3d p_W, n_W;
  };
  Place at(double x, double y) const noexcept;
};

}  // namespace impedraw
