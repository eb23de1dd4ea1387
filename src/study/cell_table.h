// A table of experiments, each cell measured in its own process: ./impedraw robustness,
// ./impedraw reach.
//
// Each finished cell appends a line to NAME.csv, so that an abort loses no finished cell. NAME.md
// and NAME.png are written at the end. A later run into the same folder keeps the lines whose
// settings are unchanged and runs the rest.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "impedraw/study/cell.h"
#include "impedraw/study/cell_processes.h"
#include "impedraw/study/csv.h"

namespace impedraw {

struct CellTableOptions {
  std::filesystem::path out;  // empty: runs/NAME in the working directory
  int jobs = 0;               // 0: as many as there are cores
  std::string only;           // a regular expression, somewhere in the name; empty: all
  bool again = false;         // discards the results of an earlier run
  bool list = false;          // prints names and commands, runs nothing
};

using Records = std::map<std::string, Record>;  // by the cell's name

struct CellTable {
  // Names the command, its files, and the plot script src/report/NAME.py (arguments CSV, PNG).
  std::string name;
  std::vector<std::string> columns;  // `cell` and `failed` (0, 1) among them
  // True if the line was made with the cell's settings.
  std::function<bool(const Record&, const Cell&)> same;
  std::function<std::string(const Cell&, const std::filesystem::path& log)>
      measure;                                                   // in a process of its own
  std::function<Record(const Cell&, const ProcessEnd&)> record;  // the line of what that gave
  std::function<std::string(const Records&)> page;               // NAME.md
  bool picture = true;                                           // NAME.png
  double time_limit = 120.0;                                     // of a cell, wall time [s]
};

// The output folder.
std::filesystem::path table_folder(const std::string& name, const CellTableOptions& options);

// The cells that match --only. Throws InputError if it is not a regular expression or matches none.
std::vector<Cell> matching(const std::vector<Cell>& cells, const std::string& pattern);

void print_cells(const std::vector<Cell>& cells);  // name and command of each

// The program's exit code: 0 when every cell of `desired` was run, also where some failed; `all`
// sets the order. Throws InputError.
int run_table(const CellTable& table, const std::vector<Cell>& all,
              const std::vector<Cell>& desired, const CellTableOptions& options);

}  // namespace impedraw
