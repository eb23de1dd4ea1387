// Fits a stroke to the surface: the stroke is cut at its corners, and a smooth line between corners
// stays within a tolerance of the artwork.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "impedraw/drawing/placement.h"
#include "impedraw/planning/path/path_spline.h"
#include "impedraw/planning/surface_height.h"

namespace impedraw {

// The pen's axis along a stroke: the surface normal, smoothed.

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

struct FitSettings {
  double tolerance = 1e-5;  // largest distance between line and artwork, seen along z [m]
  // The same beside a vertex where the artwork turns by more than 5°, as letters made of straight
  // lines do; at most a fortieth of the shorter line there [m].
  double rounding = 5e-5;
  double knot_spacing = 1e-3;  // largest distance between surface queries along the stroke [m]
  double corner_angle = 0.44;  // a larger turn is a corner, where the pen stops [rad]
  // The normals along the line are smoothed by a local parabola with Gaussian weights of this
  // standard deviation [m]; 0: none. The desired frame's angular acceleration is fed forward from
  // them, and two derivatives amplify the noise of a cloud.
  double normal_smoothing = 5e-3;
  // Normals beyond these limits are smoothed further, up to the allowance.
  TiltLimits tilt;
  double lean_deg = 0;  // of the pen (leant.h)
};

struct FittedStroke {
  std::vector<PathSpline> parts;  // corner to corner; none for a dot
  SurfaceSample first, last;
  double to = 0;  // end of the stroke (stroke_part.h) [m]
};

// A fifth of the tolerance is spent on dropping redundant points, so that finely sampled or jittery
// lines become smooth. Knots on the artwork are then added until the spline through them, together
// with the surface above them, keeps the remaining tolerance. Throws InputError for a point without
// surface (surface_height.h).
FittedStroke fit_stroke(const PlacedStroke& stroke, const SurfaceHeight& surface,
                        const FitSettings& settings);

}  // namespace impedraw
