// Breaks strokes into dashes by SVG's rules: lengths drawn and left out alternate along the line.
// Every stroke starts the pattern again at its offset.
#pragma once

#include <vector>

#include "impedraw/drawing/stroke.h"

namespace impedraw {

// Lengths are measured along the line in the pattern's own unit (Dash::to_pattern), so a transform
// that stretches a path stretches its dashes. If a closed stroke is drawn at both sides of its
// start, its last dash continues in its first; a closed stroke without a gap stays whole. A dash of
// zero length is a dot if Dash::dots is set, and nothing otherwise. The results are unbroken:
// Stroke::dash is −1. InputError: an invalid pattern (see Dash), or one so fine that it makes more
// than a million dashes.
std::vector<Stroke> dashed(const std::vector<Stroke>& strokes, const std::vector<Dash>& dashes);

// The dash's pattern for the part of the line from `start` [mm] on.
Dash dash_from(Dash dash, const std::vector<Eigen::Vector2d>& line, double start);

}  // namespace impedraw
