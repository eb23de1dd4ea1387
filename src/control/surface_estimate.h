// The surface under the tip, as perception estimates it for the controller.
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

// Query point for perception if M_d couples translation and rotation (natural or scaled inertia):
// the tip, moved along the surface towards the desired tip by at most `reach` [m].
// A query at the tip itself makes the desired normal turn with every deviation of the tip. This
// adds a one-way stiffness k_r/R from position to torque, with R the radius of curvature. On a
// tight hollow with the natural inertia, which couples both, the pen then flutters. Shaped inertia
// couples nothing: query at the tip itself, which tolerates larger model errors. The distance to
// the surface is the same at both points to e²/2R, with e the tip's deviation.
inline Eigen::Vector3d surface_query(const Eigen::Vector3d& p_WE, const Eigen::Vector3d& p_WD,
                                     const Eigen::Vector3d& n_W, double reach = 3e-3) {
  const Eigen::Vector3d way = p_WD - p_WE, along = way - n_W * n_W.dot(way);
  const double length = along.norm();
  return p_WE + (length > reach ? Eigen::Vector3d(along * (reach / length)) : along);
}

struct SurfaceEstimate {
  SurfaceStatus status = SurfaceStatus::none;
  // outward unit normal, towards the camera; valid if status is ok
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitZ();
  // from the fitted surface to the query point [m], > 0 outside; valid if status is ok
  double distance = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace impedraw
