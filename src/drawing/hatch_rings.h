// Hatch lines that run round: circles about the middle of an area's box (concentric), or insets of
// its outline, as slicers lay them (contour-parallel). Their distances from the middle or the
// outline are (k + 1/2) · spacing for rows k = 0, 1, 2, …
#pragma once

#include <functional>
#include <vector>

#include "impedraw/drawing/hatch_rows.h"
#include "impedraw/drawing/regions.h"

namespace impedraw {

enum class HatchStyle { boustrophedon, concentric, contour_parallel };

// The lines over a region of the page that is free of overlaps [mm]; they may leave it.
using HatchRings = std::function<std::vector<HatchLine>(const Outlines& region, HatchStyle style,
                                                        double spacing_mm)>;

// Distances are those of the page.
std::vector<HatchLine> page_rings(const Outlines& region, HatchStyle style, double spacing_mm);

// How many rows lie within `farthest`. InputError: more than 100,000.
double require_few_rows(double farthest, double spacing_mm);

}  // namespace impedraw
