// Draws once what lies on itself: shapes that share an edge, lines that are retraced.
#pragma once

#include <vector>

#include "impedraw/drawing/stroke.h"

namespace impedraw {

// Removes the parts of strokes that run along an earlier stroke of their layer, or along an earlier
// part of themselves, within `distance_mm` and 2°, for more than four such distances. Dashed
// strokes stay as they are, and so does what is left after 10⁸ comparisons. Returns the length
// removed [mm].
double drop_doubles(std::vector<Stroke>& strokes, double distance_mm);

}  // namespace impedraw
