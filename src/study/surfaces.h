// ./impedraw robustness --part surfaces: what the pen can follow. Rough terrain, facets, ridges,
// steps, holes, overhangs and meshes that somebody else made, each with text, a spiral and a hatch.
//
// Cells     scenarios/surfaces.csv, one a line: cell, kind, drawing, set. `drawing` is text, spiral
//           or hatch; `set` has the cell's settings, separated by "; ". Each is a scenario over
//           scenarios/surfaces.yaml that can be run alone.
// Limits    what is promised is drawn: coverage ≥ 0.98, contact ≥ 0.99, touchdown ≤ 8 N, mean speed
//           ≥ 15 mm/s; force SD and ink error RMS ≤ 0.5 N and 0.2 mm on fractal terrain with a
//           wavelength of 8 mm or more and a slope of 20° or less, elsewhere SD ≤ 1.5 N. What is
//           not promised is named.
#pragma once

#include <string>
#include <vector>

#include "impedraw/study/cell_table.h"

namespace impedraw {

// Throws InputError for a line that is none.
std::vector<Cell> surface_cells();

// The limits that the cell's record misses, comma-separated; empty: none.
std::string missed_limits(const Cell& cell, const Record& record);

// Prepares and draws the cell: its figures as JSON.
std::string measure_surface(const Cell& cell, const std::filesystem::path& log);
Record surface_record(const Cell& cell, const ProcessEnd& end);

// The program's exit code: 0 when every cell was run, also where some failed. Throws InputError.
int surfaces(const CellTableOptions& options);

}  // namespace impedraw
