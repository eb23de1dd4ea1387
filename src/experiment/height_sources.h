// The surface as the planner takes it (planning/surface_height.h), in the drawing frame P whose z
// points out of the drawing plane: the true canvas, or what the cameras saw of it.
#pragma once

#include "impedraw/canvas/canvas.h"
#include "impedraw/common/pose.h"
#include "impedraw/perception/normals.h"
#include "impedraw/planning/surface_height.h"

namespace impedraw {

// Looking along −z of P. Refers to the canvas, which must outlive it.
SurfaceHeight canvas_height(const Canvas& canvas, const Pose& X_WP);

// Refers to the estimator, which must outlive it. Starts from the last answer where that is near,
// else from the cloud's nearest column, and follows the estimated distance down to it (secant steps
// along z). Nothing off the cloud's edge.
SurfaceHeight perceived_height(const SurfaceEstimator& estimator, const Pose& X_WP);

}  // namespace impedraw
