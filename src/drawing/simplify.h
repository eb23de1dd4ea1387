// Represents the same lines with fewer points.
#pragma once

#include "impedraw/drawing/stroke.h"

namespace impedraw {

// Douglas and Peucker: drops points so that the old and the new line stay within the tolerance of
// each other. Both ends stay; a closed stroke also keeps the point farthest from its start.
// InputError: a tolerance that is negative or NaN.
Stroke simplified(const Stroke& stroke, double tolerance_mm);

}  // namespace impedraw
