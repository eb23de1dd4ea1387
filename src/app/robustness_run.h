// Runs cells in processes of their own, several at a time: what hangs, crashes or blows up is one failed cell.
//
// A cell has failed where it was refused, stopped or took longer than the limit; where a stroke has no ink, under 98 % of the pen-down
// samples have, over 5 % of the ink's length lies over 1 mm from its target, or its mean speed is under 90 % of the speed asked for.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "app/robustness_record.h"

namespace impedraw {

inline constexpr double kLeastContact = 0.98, kMostAstray = 0.05, kLeastSpeed = 0.9;

struct CellRunSettings {
  int jobs = 1;
  double time_limit = 120.0;             // of a cell, wall time [s]
  std::filesystem::path scratch;         // a folder for logs, which are removed
};

struct CellRunHooks {
  std::function<void(const Cell&, const CellResult&)> finished;  // as each ends, in no order
  std::function<void()> waiting;                                 // several times a second
  std::function<bool()> interrupted;                             // looked at as often: ends what runs, without a result
};

// In this process. Throws nothing: what goes wrong is the result's cause.
CellResult run_cell(const Cell& cell, const std::filesystem::path& log);

// False: interrupted. Must be called while the program has one thread. Throws std::runtime_error when no process can be started.
bool run_cells(const std::vector<Cell>& cells, const CellRunSettings& settings, const CellRunHooks& hooks);

}  // namespace impedraw
