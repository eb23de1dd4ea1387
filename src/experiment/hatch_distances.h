// Distances on the surface over a placed page, by which hatch lines lie evenly there
// (drawing/hatch_frame.h, planning/cover/surface_grid.h).
#pragma once

#include <vector>

#include "impedraw/drawing/hatch_frame.h"
#include "impedraw/drawing/placement.h"
#include "impedraw/drawing/stroke.h"
#include "impedraw/planning/surface_height.h"

namespace impedraw {

// Distances on the surface for a page that is projected. Where there is no surface, the one about
// that place is continued.
SurfaceDistances hatch_distances(const SurfaceHeight& surface, const Placement& placement,
                                 const std::vector<Area>& areas);

}  // namespace impedraw
