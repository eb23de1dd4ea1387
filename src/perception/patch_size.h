// The number of points that a normal of a noisy cloud needs.
//
// The normal of a patch of k points within the radius r, off the fitted surface by s, errs by about
//   e = 4 s / (√k r),   and since r grows with √k, e falls with 1/k.
// The smoothest quarter of the cloud's patches tells s / r: the others have shape beyond it.
// The answer is the k that brings e to kCalmNormal, between the given one and kMostNeighbours.
#pragma once

#include "impedraw/perception/normals.h"

namespace impedraw {

// Measured on a bowl in a stereo camera's images, with 1.5 mm of noise at 1 m that hangs together
// over some pixels: a normal that errs by this costs a pen of natural inertia 0.2 N [rad].
inline constexpr double kCalmNormal = 0.004;

// Throws InputError like SurfaceEstimator.
int calm_patch(const PointCloud& cloud, const NormalSettings& settings);

}  // namespace impedraw
