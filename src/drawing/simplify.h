// Represents the same lines with fewer points and strokes.
#pragma once

#include <vector>

#include "impedraw/drawing/stroke.h"

namespace impedraw {

// Douglas and Peucker: drops points so that the old and the new line stay within the tolerance of
// each other. Both ends stay; a closed stroke also keeps the point farthest from its start.
// InputError: a tolerance that is negative or NaN.
Stroke simplified(const Stroke& stroke, double tolerance_mm);

// Joins strokes of one layer whose ends lie within `gap_mm` of each other, nearest ends first.
// Where they do not touch, the pen draws the gap. Dots, closed strokes and dashed strokes stay as
// they are. A chain that returns to its own start stays open there unless it touches. The joined
// stroke takes the place of its first part. InputError: a gap that is negative or NaN.
std::vector<Stroke> joined(const std::vector<Stroke>& strokes, double gap_mm);

}  // namespace impedraw
