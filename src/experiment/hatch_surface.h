// Hatch lines that lie evenly on the surface over a placed page (drawing/hatch.h): by distances
// along it (planning/cover/surface_grid.h).
#pragma once

#include <vector>

#include "impedraw/drawing/hatch.h"
#include "impedraw/drawing/placement.h"
#include "impedraw/drawing/stroke.h"
#include "impedraw/planning/surface_height.h"

namespace impedraw {

// For a page that is projected. Where there is no surface, the one about that place is continued.
// Rings are level lines of the distance from an area's outline or middle, on a grid of a third of
// the spacing: their corners are cut by that much.
HatchSurface hatch_surface(const SurfaceHeight& surface, const Placement& placement,
                           const std::vector<Area>& areas);

}  // namespace impedraw
