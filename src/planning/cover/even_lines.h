// Moves lines sideways, on which a round footprint removes, until the dose is even.
//
//   E      = ∫ e² dA over the places,  e = d / d̄ − 1         d: dose (even_forces.h), d̄: its mean
//   ∂E/∂c  ∝ w ∇m − m u,  m = ∫ e p dA under the footprint         of a knot c
//
// w: way at the knot, u: along the line, which gets longer where it bends, p: pressure over its
// mean (cover_lines.h). ∇m: by differences along the surface. The rounds descend on E with
// momentum, smoothed along the lines, by at most kMost each. No knot leaves the centres.
#pragma once

#include "impedraw/planning/cover/even_forces.h"

namespace impedraw {

// The centres' clearance and feet are read. The first `fixed` lines stay where they are. Returns
// the coefficient of variation that is left, √(E / area).
double even_lines(const SurfaceGrid& grid, const Centres& centres, const std::vector<char>& places,
                  std::size_t fixed, PlaneLines* lines);

// Leaves out parts of the lines, and appends parts once more, one at a time, as long as that makes
// the dose more even: in areas that are narrower than two lines, and beside what was cut. All that
// the lines surely press is pressed still (cover_lines.h).
void even_parts(const SurfaceGrid& grid, const PressedFeet& feet, const std::vector<char>& places,
                PlaneLines* lines);

}  // namespace impedraw
