// The command `cover`: treats an area with a pad.
#pragma once

#include <filesystem>

#include "impedraw/experiment/draw_options.h"

namespace impedraw {

// Leaves the results of a drawing (its strokes are cover.csv), cover.json and cover.png;
// metrics.json has the area's metrics, too. Returns the exit code. Throws InputError before
// anything moves.
int cover(const DrawOptions& options, const std::filesystem::path& region, bool table);

}  // namespace impedraw
