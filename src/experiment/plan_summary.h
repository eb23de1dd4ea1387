// Summarises the pre-flight and the path of a drawing before anything moves.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "impedraw/experiment/experiment.h"
#include "impedraw/planning/preflight/preflight.h"
#include "impedraw/planning/wrap/distortion.h"

namespace impedraw {

// Ratios of lengths, areas and angles on the surface to those on the page.
Distortion projected_distortion(const PlannedDrawing& drawing);
Distortion wrapped_distortion(const PlannedDrawing& drawing);  // requires a wrapped drawing

double length_not_drawable(const PlannedDrawing& drawing);  // in the drawing plane [m]

// strokes, drawable_parts, pen_down_m, pen_up_m, page_size_mm [x, y] of the strokes on the page,
// size_mm, the same on the canvas as seen along the drawing axis, notes (notes_of()), time_s,
// distortion, margins, not_drawable: [{stroke, from_mm, to_mm, problem, text, page_mm, world_m}].
nlohmann::ordered_json plan_json(const PlannedDrawing& drawing);

// The same as text.
std::string plan_text(const PlannedDrawing& drawing);

// Pre-flight findings as text. Strokes have the artwork's numbers.

// Names the stroke, the part of it, the problem, its size and its location.
std::string finding_text(const Finding& finding);

// The same, as the error message of a refused drawing. `seen`: the surface was seen by cameras.
std::string refusal_text(const Finding& finding, bool seen);

}  // namespace impedraw
