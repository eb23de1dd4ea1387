// Runs and judges a cell of ./impedraw robustness.
//
// A cell has failed where it was refused, stopped or took longer than the limit; where a stroke has
// no ink, under 98 % of the pen-down samples have, over 5 % of the ink's length lies over 1 mm from
// its target, or its mean speed is under 90 % of the speed asked for.
#pragma once

#include <filesystem>
#include <string>

#include "impedraw/study/cell_processes.h"
#include "impedraw/study/robustness_record.h"

namespace impedraw {

inline constexpr double kLeastContact = 0.98, kMostAstray = 0.05, kLeastSpeed = 0.9;

// Runs in this process. Throws nothing: errors become the result's cause.
CellResult run_cell(const Cell& cell, const std::filesystem::path& log);

// Transfers a result from the child process to its parent.
std::string result_text(const CellResult& result);
CellResult result_of(const ProcessEnd& end);

}  // namespace impedraw
