// What perception tells the controller of the surface under the tip.
#pragma once

#include <limits>

#include <Eigen/Core>

namespace impedraw {

enum class SurfaceStatus {
  ok,
  none,      // no perception at all
  too_few,   // fewer than k points within reach of the tip
  off_edge,  // the tip lies beyond the edge of the cloud
};

struct SurfaceEstimate {
  SurfaceStatus status = SurfaceStatus::none;
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitZ();  // unit normal, outward (towards the camera that saw it); meaningful if ok
  double distance = std::numeric_limits<double>::quiet_NaN();       // of the query point to the fitted surface [m], > 0 outside
};

}  // namespace impedraw
