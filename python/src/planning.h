// What the planner and the pre-flight take from Python.
#pragma once

#include <vector>

#include "impedraw/drawing/placement.h"
#include "impedraw/planning/surface_height.h"
#include "record.h"

namespace impedraw::python {

// Arrays of shape (N, 2) in the drawing plane [m]. Throws ValueError naming the stroke.
std::vector<PlacedStroke> strokes_of(nb::handle strokes);

// Of an estimator, a canvas or the height of a level plane in P [m]; refers to the first two.
SurfaceHeight height_of(nb::handle surface, const Pose& X_WP);

}  // namespace impedraw::python
