// Moves lines sideways, on which a round footprint removes, until the dose is even.
//
//   E      = ∫ e² dA over the places,  e = d / d̄ − 1         d: dose (even_forces.h), d̄: its mean
//   ∂E/∂c  ∝ w ∮ e t ds − m u                                 of a knot c, by its footprint's rim
//
// w: way at the knot, t: along the surface from the knot to the rim, u: along the line, m: the mean
// of e under the footprint, for a line that bends gets longer. The rounds descend on E, smoothed
// along the lines, by at most kMost each. No knot leaves the centres. A disc of constant pressure
// stands for the pad.
#pragma once

#include "impedraw/planning/cover/even_forces.h"

namespace impedraw {

// `clearance`: of the centres (cover_lines.h). The first `fixed` lines stay where they are.
void even_lines(const SurfaceGrid& grid, const std::vector<double>& clearance, double radius,
                const std::vector<char>& places, std::size_t fixed, PlaneLines* lines);

}  // namespace impedraw
