// What the pre-flight and the path tell of a drawing before anything moves.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "app/experiment.h"

namespace impedraw {

// strokes, drawable_parts, pen_down_m, pen_up_m, time_s, distortion, margins, not_drawable: [{stroke, from_mm, to_mm, problem, text, page_mm, world_m}].
nlohmann::ordered_json plan_json(const Experiment& experiment);

// The same for a reader.
std::string plan_text(const Experiment& experiment);

}  // namespace impedraw
