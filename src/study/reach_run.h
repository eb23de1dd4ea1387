// Draws and judges a combination of ./impedraw reach.
//
// strokes        of the artwork, hatched and dashed, and `asked` their length [mm]; all lengths are
//                in the drawing plane
// parts          that are promised, and `promised` their length; of what is not, `undrawable`,
//                `reasons` counts the findings by problem
// unnamed        length neither promised nor named: 0 but for a fault
// rms_to_45      distance of the ink to its own target, root mean square over the ink where the
//                canvas leans by less than 45° from the
//                drawing axis
//
// Verdict: `met`; `nothing` where nothing can be drawn and all of it is named; `missed` with the
// limits that were; `refused` (bad input), `stopped`, `error`, `crashed`, `timeout`.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "impedraw/experiment/experiment.h"
#include "impedraw/metrics/ink_match.h"
#include "impedraw/run/run.h"
#include "impedraw/study/cell.h"
#include "impedraw/study/cell_processes.h"
#include "impedraw/study/csv.h"

namespace impedraw {

inline constexpr double kLeastCoverage = 0.995, kMostInkError = 0.2,
                        kGentleSlope = 45.0;  // [1], [mm], [deg]
inline constexpr double kMostUnnamed = 0.1;   // of rounding [mm]

const std::vector<std::string>& reach_columns();

// A digest of the settings and of the artwork and mesh files. Lines of an earlier table are kept if
// it is unchanged.
std::string settings_digest(const Cell& cell);

// The artwork's length that is neither promised nor named [mm].
double unnamed_mm(const Experiment& experiment);

// Root mean square of the ink's error where the canvas leans by less than `slope` [mm]; NaN where
// no ink does.
double gentle_error_mm(const Experiment& experiment, const RunData& run, const InkMatch& drawn,
                       double slope_deg);

// Runs in this process; throws nothing. `ink_file` gets the picture's lines. The result is for
// reach_record().
std::string measure_reach(const Cell& cell, const std::filesystem::path& log,
                          const std::filesystem::path& ink_file);

Record reach_record(const Cell& cell, const ProcessEnd& end);

}  // namespace impedraw
