// The area that `cover` treats: cover.region, seen along the drawing axis.
#pragma once

#include <string>
#include <vector>

#include "impedraw/common/pose.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/planning/cover/surface_grid.h"

namespace impedraw {

struct CoverRegion {
  std::vector<char> inside;   // of each vertex
  std::vector<double> tones;  // of each vertex: 0 nothing, 1 ink only (Area::tone); empty: a mesh
  std::vector<std::string> left_out = {};  // of the SVG: Artwork::warnings but those of lines
};

// The tones of an SVG's areas that lie over one another add up. Throws InputError for a file that
// is neither an SVG with areas nor a mesh with a colour.
CoverRegion region_of(const Scenario& scenario, const SurfaceGrid& grid, const Pose& X_WP);

}  // namespace impedraw
