// A stroke laid on the surface: cut at its corners, between them a smooth line that stays within a
// stated distance of the artwork.
#pragma once

#include <vector>

#include "impedraw/drawing/placement.h"
#include "impedraw/planning/path/path_spline.h"
#include "impedraw/planning/surface_height.h"

namespace impedraw {

struct FitSettings {
  double tolerance = 1e-5;     // largest distance of line and artwork, seen along z [m]
  double knot_spacing = 1e-3;  // the surface is asked at least this often along the stroke [m]
  double corner_angle = 0.44;  // a turn above this is a corner, at which the pen stops [rad]
  // The normals along the line are smoothed, by a local parabola with Gaussian weights of this
  // standard deviation: what the desired frame's angular acceleration is fed forward from must not
  // have the noise of a cloud, which two derivatives make large [m]; 0: none.
  double normal_smoothing = 5e-3;
};

struct FittedStroke {
  std::vector<PathSpline> parts;  // corner to corner; none for a dot
  SurfaceSample first, last;
  double from = 0, to = 0;  // where on the stroke (stroke_part.h) [m]
  int number = 0;           // PlacedStroke::number
};

// A fifth of the tolerance goes into dropping points that make no difference, so that finely
// sampled or jittery lines are not drawn jittery. Then knots on the artwork are added until the
// spline through them, together with the surface above them, keeps the rest of it. InputError: a
// point without surface (surface_height.h).
FittedStroke fit_stroke(const PlacedStroke& stroke, const SurfaceHeight& surface,
                        const FitSettings& settings);

}  // namespace impedraw
