// Areas that were marked on an object, as `cover` takes them: an SVG of which a millimetre is one
// of the drawing plane P.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "impedraw/drawing/placement.h"

namespace impedraw {

struct MarkedAreas {
  std::string svg;
  PlacementSettings placement;  // of the SVG's page: its areas lie where they were marked
};

// Outlines in P [m], each joined to its beginning. All that one of them goes round is marked.
// Throws InputError where they enclose nothing, and for an outline of fewer than three points.
MarkedAreas marked_areas(const std::vector<std::vector<Eigen::Vector2d>>& outlines);

}  // namespace impedraw
