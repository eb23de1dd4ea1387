// The pen's axis along a stroke: the surface normal, smoothed.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace impedraw {

// Limits on the turning of the pen's axis, per length of surface at the drawing speed.
struct TiltLimits {
  double allowance = 0.17;  // largest angle between axis and smoothed normal [rad]
  double turn = 30.0;       // |dn/ds| [rad/m]
  double bend = 6400.0;     // |d²n/ds²| [rad/m²]
};

struct AxisKnot {
  double along;       // on the stroke, strictly increasing [m]
  Eigen::Vector3d p;  // on the surface [m]
  Eigen::Vector3d n;  // surface normal there, unit
  bool corner;        // the line's direction jumps, and the pen stops
};

// The axis at each knot. Normals are smoothed by a local parabola with Gaussian weights of standard
// deviation `smoothing` [m]; 0: not at all. Between corners they are smoothed for themselves: a
// smooth surface's normal turns another way behind a corner. Where the result exceeds `limits`, it
// is smoothed across corners, too, and then further, up to the allowance.
std::vector<Eigen::Vector3d> smoothed_axes(const std::vector<AxisKnot>& knots, double smoothing,
                                           const TiltLimits& limits);

}  // namespace impedraw
