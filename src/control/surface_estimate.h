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

// Where to query perception if M_d couples translation and rotation (natural or scaled inertia): at
// the tip, moved along the surface towards the desired tip, by `reach` at most [m].
// Asked at the tip itself, the desired normal turns with every deviation of the tip: a stiffness
// k_r/R from position to torque with none back, R the radius of curvature. On a tight hollow that
// is not symmetric enough for the natural inertia, which couples both: the pen flutters. With
// shaped inertia, which couples nothing, ask at the tip itself: it stands larger errors of the
// model. Within the deviations of drawing the distance to the surface is the same at both places,
// to e²/2R.
inline Eigen::Vector3d surface_query(const Eigen::Vector3d& p_WE, const Eigen::Vector3d& p_WD,
                                     const Eigen::Vector3d& n_W, double reach = 3e-3) {
  const Eigen::Vector3d way = p_WD - p_WE, along = way - n_W * n_W.dot(way);
  const double length = along.norm();
  return p_WE + (length > reach ? Eigen::Vector3d(along * (reach / length)) : along);
}

struct SurfaceEstimate {
  SurfaceStatus status = SurfaceStatus::none;
  // unit normal, outward: towards the camera that saw it; meaningful if ok
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitZ();
  // of the query point to the fitted surface [m], > 0 outside; meaningful if ok
  double distance = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace impedraw
