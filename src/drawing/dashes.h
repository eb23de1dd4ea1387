// Strokes broken by their dashes, by SVG's rules: lengths drawn and left out in turn along the
// line, from the offset on, anew for each stroke.
#pragma once

#include <vector>

#include "impedraw/drawing/stroke.h"

namespace impedraw {

// Lengths are taken along the line in the pattern's own unit (Dash::to_pattern), so that a
// transform which stretches a path stretches its dashes. A closed stroke's last dash goes on in its
// first where both are drawn at its start; one without any gap stays whole. A dash of no length is
// a dot where Dash::dots says so, and nothing otherwise. What comes out is unbroken: Stroke::dash
// is −1. InputError: a pattern that is none (Dash), or one so fine that more than a million dashes
// come out.
std::vector<Stroke> dashed(const std::vector<Stroke>& strokes, const std::vector<Dash>& dashes);

}  // namespace impedraw
