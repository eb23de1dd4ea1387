// Draws a relief with Cairo: shading, contours, outline. Private to src/report.
#pragma once

#include <cairo.h>

#include "impedraw/report/relief.h"
#include "impedraw/report/sheet.h"

namespace impedraw {

inline constexpr Colour kContour{0.55, 0.50, 0.42}, kOutline{0.36, 0.33, 0.29};

void draw_relief(cairo_t* cr, const Relief& relief);

// Appends p unless it is nearer than `step` to the last point of the line.
void extend(std::vector<Eigen::Vector2d>& line, const Eigen::Vector2d& p, double step, bool always);

// Extends the box by `share` of its longer side, at least 1 mm.
Eigen::AlignedBox2d with_margin(Eigen::AlignedBox2d box, double share);

}  // namespace impedraw
