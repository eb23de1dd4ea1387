// A note on a surface that is too rough for a calm force, as the cameras show it.
//
// The force scatters by heights that the fitted patches do not follow: their residual,
// RMS along the strokes. On plates with noise (0.1 to 1 mm, grid 1 to 6 mm) and ribs (0.3 to 2 mm,
// 5 to 30 mm long) at 50 mm/s and 5 N, the force's standard deviation was 0.4 to 1.1 N above a
// residual of 0.06 mm, and 0.05 to 0.3 N below, but for noise on a grid of 1 mm. Only for cameras
// without noise, which has a residual, too.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "impedraw/common/pose.h"
#include "impedraw/drawing/placement.h"
#include "impedraw/perception/normals.h"
#include "impedraw/planning/surface_height.h"

namespace impedraw {

// The note, or nullopt on calm ground. `strokes` are in the drawing plane, `X_WP` its pose. Looks
// at most at some 500 places.
std::optional<std::string> roughness_note(const std::vector<PlacedStroke>& strokes,
                                          const SurfaceHeight& surface, const Pose& X_WP,
                                          const SurfaceEstimator& seen);

}  // namespace impedraw
