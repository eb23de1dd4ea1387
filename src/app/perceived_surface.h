// The cloud as the planner's surface: the height above a point of the drawing plane, looking along −z.
#pragma once

#include "perception/normals.h"
#include "planning/surface_height.h"

namespace impedraw {

// Refers to the estimator, which must outlive it. Starts from the last answer where that is near, else from the cloud's nearest column,
// and follows the estimated distance down to it (secant steps along z). Nothing off the cloud's edge.
SurfaceHeight perceived_height(const SurfaceEstimator& estimator);

}  // namespace impedraw
