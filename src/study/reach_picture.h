// What src/study/reach.py draws of one combination, as JSON: ink, what was promised and what cannot
// be drawn, seen along the drawing axis, and the canvas's shading beneath.
//
//   area         [left, right, bottom, top] [mm]: a square about the drawing's centre; all points
//                are [right, up] in it
//   shade        rows from the top of columns from the left, 0 … 255; null where there is no canvas
//   ink, promised, undrawable   lists of lines
#pragma once

#include <filesystem>

#include "impedraw/experiment/experiment.h"
#include "impedraw/metrics/ink_match.h"

namespace impedraw {

// `run` and `drawn` null: nothing was drawn. Throws std::runtime_error where the file cannot be
// written.
void write_reach_picture(const Experiment& experiment, const RunData* run, const InkMatch* drawn,
                         const std::filesystem::path& file);

}  // namespace impedraw
