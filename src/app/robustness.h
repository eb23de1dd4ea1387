// ./impedraw robustness: where the method holds and where it ends, measured cell by cell (robustness_cells.h).
//
// The folder gets robustness.csv, a line as each cell ends, and at the end robustness.md and robustness.png. Started again with the same
// folder it keeps the lines whose settings are still the same and runs the rest.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/robustness_cells.h"

namespace impedraw {

struct RobustnessOptions {
  std::filesystem::path out;  // empty: runs/robustness in the working directory
  int jobs = 0;               // 0: as many as there are cores
  std::string only;           // a regular expression, somewhere in the name; empty: all
  bool again = false;         // keeps nothing of an earlier run
  bool list = false;          // prints names and commands, runs nothing
};

// The program's exit code: 0 when every cell was run, also where some failed. Throws InputError.
int robustness(const RobustnessOptions& options);

// The same of other cells; `all` sets the columns, `wanted` is run.
int run_matrix(const std::vector<Cell>& all, const std::vector<Cell>& wanted, const RobustnessOptions& options, double time_limit = 120.0);

}  // namespace impedraw
