// Fewer points, and fewer strokes, for the same lines.
#pragma once

#include <vector>

#include "impedraw/drawing/stroke.h"

namespace impedraw {

// Douglas and Peucker's: leaves out points so that none of the line, old or new, lies farther than
// the tolerance from the other. Both ends stay, of a closed stroke the point farthest from its
// start, too. InputError: a tolerance that is negative or no number.
Stroke simplified(const Stroke& stroke, double tolerance_mm);

// Strokes of one layer whose ends lie within `gap_mm` of one another become one, nearest ends
// first; where they do not touch, the pen draws the gap. Dots, closed and dashed strokes stay as
// they are; a chain that comes back to its own start stays open there unless it touches. The joined
// stroke stands where the first of its parts stood. InputError: a gap that is negative or no
// number.
std::vector<Stroke> joined(const std::vector<Stroke>& strokes, double gap_mm);

}  // namespace impedraw
